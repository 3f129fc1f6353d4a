#include "bench/error_peers.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <sys/wait.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace tandem::bench {
namespace {

/// One word for the shell.
std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// What a command prints, and how it ended.
std::pair<std::string, int> output_of(const std::string& command) {
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::string text;
  std::array<char, 65536> block{};
  while (const std::size_t n = std::fread(block.data(), 1, block.size(), pipe))
    text.append(block.data(), n);
  const int status = pclose(pipe);
  return {text, WIFEXITED(status) ? WEXITSTATUS(status) : -1};
}

std::string case_for_python(int index) {
  const ErrorPoint& p = kErrorPoints[static_cast<std::size_t>(index)];
  return nlohmann::json{{"case", p.name},
                        {"stiffness", p.stiffness},
                        {"damping", p.damping},
                        {"seconds", p.seconds},
                        {"rates", kErrorRates},
                        {"grid", kGridRate},
                        {"hand_mass", kHandMass},
                        {"object_mass", kObjectMass},
                        {"thrown", kThrown},
                        {"pushed", kPushed},
                        {"gap", kGap},
                        {"flight", kFlight},
                        {"draw_spring", kDrawSpring},
                        {"draw_speed", kDrawSpeed},
                        {"normal_force", kNormalForce},
                        {"sticks", kSticks},
                        {"slips", kSlips},
                        {"slide_friction", kSlideFriction},
                        {"gravity", kGravity},
                        {"slide_speed", kSlideSpeed},
                        {"box_size", kBoxSize},
                        {"moments", kMoments},
                        {"spin", kSpin}}
      .dump();
}

}  // namespace

std::vector<Peer> find_peers(const std::string& python) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  std::vector<Peer> peers;
  for (const auto& [name, package] :
       {std::pair{"box2d", "libbox2d-dev"}, std::pair{"bullet", "libbullet-dev"},
        std::pair{"ode", "libode-dev"}}) {
    const fs::path program = folder / (std::string("bench_error_") + name);
    Peer peer{name, quoted(program.string()), {}};
    if (!fs::exists(program, ignored))
      peer.missing = fmt::format(
          "not built: apt install {}, configure again, build the target bench_peers", package);
    peers.push_back(peer);
  }
  Peer mujoco{"mujoco", quoted(python), {}};
  if (output_of(mujoco.command + " -c 'import mujoco' 2>/dev/null").second != 0)
    mujoco.missing = "'" + python + "' has no mujoco: pip install mujoco, or name another --python";
  mujoco.command += " " + quoted(TANDEM_SOURCE_DIR "/bench/error_mujoco.py");
  peers.push_back(mujoco);
  return peers;
}

std::vector<PeerRun> run_peer(const Peer& peer, int point) {
  const std::string argument =
      peer.name == "mujoco" ? case_for_python(point) : std::to_string(point);
  const auto [text, status] = output_of(peer.command + " " + quoted(argument));
  if (status != 0)
    throw std::runtime_error(fmt::format("{} ended with {} on case {}", peer.name, status, point));
  std::vector<PeerRun> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() != '{') continue;  // engines talk
    const nlohmann::json json = nlohmann::json::parse(line);
    PeerRun run{json.at("setting"), json.at("hz"), {json.at("ns_per_s"), {}}};
    for (const auto& x : json.at("samples"))
      run.run.samples.push_back(x.is_null() ? std::numeric_limits<double>::quiet_NaN()
                                            : x.get<double>());
    out.push_back(std::move(run));
  }
  return out;
}

}  // namespace tandem::bench
