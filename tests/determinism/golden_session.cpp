// Runs fixed sessions in virtual time and hashes the bits of every state after every packet period.
//
//   golden_session check FOLDER    compares with FOLDER/golden_hashes.txt; where a hash differs,
//   says
//                                  in which row of FOLDER/<session>.csv the trajectory leaves it
//   golden_session accept FOLDER   writes both anew: in a commit of its own, with a line under
//                                  "Dynamics" in CHANGELOG.md that says why
//
// The hash says that something changed, the trajectory where.

#include <bit>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "analysis/state_vector.h"
#include "analysis/with_loop.h"
#include "scene/load_scene.h"

namespace {

using namespace tandem;

struct Session {
  std::string name, scene;
  std::vector<std::string> sets;
  core::LinkModelParameters link;
  double seconds;
};

struct Outcome {
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a
  std::string csv;
};

core::LinkModelParameters rough(core::JitterKind kind) {
  core::LinkModelParameters link;
  link.delay_ticks = 9.4;
  link.jitter = kind;
  link.jitter_ticks = 6.0;
  link.loss = 0.05;
  link.duplicate = 0.02;
  link.burst_enter = 0.002;
  link.burst_leave = 0.05;
  link.seed = 5;
  return link;
}

std::vector<Session> sessions() {
  return {
      {"axis_distributed", "axis_distributed", {}, {}, 4.0},
      {"box_distributed", "box_distributed", {}, {}, 20.0},
      {"box_distributed_rough",
       "box_distributed",
       {"reconstruction.kind=EXTRAPOLATE", "object.box.compensation=0.3"},
       rough(core::JitterKind::kNormal),
       20.0},
      {"box_split_rough", "box_distributed_split", {}, rough(core::JitterKind::kExponential), 18.0},
      {"box_central", "box_central", {}, {}, 18.0},
      {"box_thesis", "box_distributed_thesis", {}, rough(core::JitterKind::kUniform), 8.0},
      {"space_box", "space_box", {}, {}, 6.0},
  };
}

Outcome run(const Session& session) {
  const core::Scene scene = scene::load_scene(session.scene, session.sets);
  core::NetworkModel network;
  network.set_all(session.link);
  return analysis::with_loop(scene, network, [&]<typename Loop>(Loop& loop) {
    Outcome outcome;
    int period = 0;
    while (loop.time() < session.seconds) {
      loop.advance_packet_period();
      const auto states = analysis::states_of(loop);
      for (const analysis::StateEntry& s : states) {
        std::uint64_t bits = std::bit_cast<std::uint64_t>(*s.value);
        for (int byte = 0; byte < 8; ++byte, bits >>= 8)
          outcome.hash = (outcome.hash ^ (bits & 0xffu)) * 0x100000001b3u;
      }
      if (period++ % 32 != 0) continue;  // four rows a second: a person reads this
      char number[40];
      std::snprintf(number, sizeof number, "%.6f", loop.time());
      outcome.csv += number;
      for (int u = 0; u < loop.user_count(); ++u) {
        auto body = loop.object(u, 0);
        std::vector<analysis::StateEntry> entries;
        Loop::World::visit_body(body, analysis::StateCollector(entries));
        for (const auto& e : entries) {
          std::snprintf(number, sizeof number, ",%.12g", *e.value);
          outcome.csv += number;
        }
      }
      outcome.csv += '\n';
    }
    return outcome;
  });
}

std::string hex(std::uint64_t value) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

std::string read(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void say_where(const std::string& expected, const std::string& got) {
  std::istringstream a(expected), b(got);
  std::string line_a, line_b;
  while (std::getline(a, line_a) && std::getline(b, line_b))
    if (line_a != line_b) {
      std::printf("  first row that differs\n    expected %s\n    got      %s\n", line_a.c_str(),
                  line_b.c_str());
      return;
    }
  std::printf("  the rows agree to 12 digits: the difference is in the last bits\n");
}

}  // namespace

int main(int argc, char** argv) {
  const std::string action = argc == 3 ? argv[1] : "";
  if (action != "check" && action != "accept") {
    std::fprintf(stderr, "usage: golden_session check|accept FOLDER\n");
    return 2;
  }
  const std::string folder = std::string(argv[2]) + "/";
  std::istringstream golden(read(folder + "golden_hashes.txt"));
  std::string accepted;
  int wrong = 0;
  for (const Session& session : sessions()) {
    const Outcome outcome = run(session);
    const std::string hash = hex(outcome.hash);
    accepted += session.name + " " + hash + "\n";
    if (action == "accept") {
      std::ofstream(folder + session.name + ".csv", std::ios::binary) << outcome.csv;
      continue;
    }
    std::string name, expected;
    golden >> name >> expected;
    const bool same = name == session.name && expected == hash;
    std::printf("%-24s %s %s\n", session.name.c_str(), hash.c_str(),
                same ? "as accepted" : ("DIFFERS from " + expected).c_str());
    if (same) continue;
    ++wrong;
    say_where(read(folder + session.name + ".csv"), outcome.csv);
  }
  if (action == "accept") std::ofstream(folder + "golden_hashes.txt", std::ios::binary) << accepted;
  return wrong == 0 ? 0 : 1;
}
