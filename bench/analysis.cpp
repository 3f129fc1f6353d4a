#include "bench/analysis.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

#include "analysis/boundary.h"
#include "analysis/lifted.h"
#include "analysis/resampled.h"
#include "bench/boundary_accuracy.h"
#include "bench/processor_time.h"
#include "bench/report.h"
#include "scene/load_scene.h"

namespace tandem::bench {

namespace {

using analysis::Axis;
using analysis::Knob;

struct Figure {
  std::string name;
  core::Scene scene;
  std::string x_fields, y_fields;
  Axis x, y;
};

void set_gains(core::Scene& scene, const std::string& couplers, double stiffness) {
  Knob(scene, couplers).set(scene, stiffness);
}

std::vector<Figure> figures() {
  core::Scene central = scene::load_scene("axis_central");
  core::Scene distributed = scene::load_scene("axis_distributed");
  for (core::Scene* scene : {&central, &distributed})
    for (core::CouplerParameters& c : scene->couplers) c.gain.damping = 10.0;
  const std::string own = "coupler.k11.stiffness,coupler.k22.stiffness",
                    other = "coupler.k12.stiffness,coupler.k21.stiffness",
                    copies = "coupler.ko1.stiffness,coupler.ko2.stiffness";
  const Axis wide{0.0, 25000.0, 100}, narrow{0.0, 6000.0, 100};
  std::vector<Figure> out{{"fig5.1", central, "coupler.k1.stiffness", "coupler.k2.stiffness", wide,
                           Axis{0.0, 4000.0, 100}},
                          {"fig5.2", distributed, other, own, narrow, wide},
                          {"fig5.3", distributed, own, copies, wide, narrow},
                          {"fig5.4", distributed, copies, other, narrow, narrow}};
  set_gains(out[1].scene, copies, 1000.0);
  set_gains(out[2].scene, other, 300.0);
  set_gains(out[3].scene, own, 2000.0);
  return out;
}

std::string output_of(const std::string& command) {
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::string text;
  std::array<char, 4096> block{};
  while (const std::size_t n = std::fread(block.data(), 1, block.size(), pipe))
    text.append(block.data(), n);
  if (pclose(pipe) != 0)
    throw std::runtime_error(command + " failed: the peer needs numpy (apt install python3-numpy)");
  return text;
}

nlohmann::ordered_json roads_table(std::string& text) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  text += "one point, microseconds, and error of the spectral radius against the running loop\n";
  for (const char* name : {"axis_central", "axis_distributed"})
    for (int d = 0; d < 4; ++d) {
      const core::Scene scene = scene::load_scene(name);
      core::NetworkModel network;
      network.set_round_trip(d, scene.ticks_per_packet());
      const auto two = analysis::TwoSites::of(scene, network);
      const auto timed = [&](int times, auto&& work) {
        const double start = core_seconds();
        for (int i = 0; i < times; ++i) work();
        return 1e6 * (core_seconds() - start) / times;
      };
      double sink = 0.0, resampled = 0.0, measured = 0.0;
      const double routh_us = timed(20000, [&] { sink += two->margin(scene).margin; });
      const double resampled_us = timed(500, [&] {
        resampled = analysis::judge(analysis::resampled_system(scene, network)).radius;
      });
      const double measured_us = timed(20, [&] {
        measured = analysis::judge(analysis::measured_system(scene, network)).radius;
      });
      const double error = std::abs(resampled - measured);
      const bool agrees = (sink > 0.0) == (measured < 1.0);
      text += fmt::format(
          "  {:17} d={}: Routh {:6.2f} (sign {})  resampled {:7.1f} (off {:.0e})  measured "
          "{:8.1f}\n",
          name, d, routh_us, agrees ? "agrees" : "DIFFERS", resampled_us, error, measured_us);
      out.push_back({{"scene", name},
                     {"d", d},
                     {"routh_us", routh_us},
                     {"routh_sign_agrees", agrees},
                     {"resampled_us", resampled_us},
                     {"resampled_error", error},
                     {"measured_us", measured_us}});
    }
  return out;
}

void run(int rounds, const std::string& json_file) {
  const nlohmann::json peer = nlohmann::json::parse(
      output_of("/usr/bin/python3 " TANDEM_SOURCE_DIR "/bench/stability_maps.py"));
  nlohmann::ordered_json json;
  std::string text =
      "stable points of 100 x 100, seconds on one core\n"
      "  map          stable   numpy   Tandem   ratio   traced (evaluations)\n";
  double ours = 0.0, theirs = 0.0, traced = 0.0;
  bool equal = true;
  int checked = 0, wrong = 0;
  std::int64_t evaluations = 0;
  nlohmann::ordered_json maps = nlohmann::ordered_json::array();
  std::size_t at = 0;
  for (const Figure& f : figures())
    for (int d = 0; d < 4; ++d, ++at) {
      core::NetworkModel network;
      network.set_round_trip(d, f.scene.ticks_per_packet());
      const Knob x(f.scene, f.x_fields), y(f.scene, f.y_fields);
      std::vector<double> seconds, tracing;
      analysis::StabilityMap map;
      std::int64_t used = 0;
      std::size_t segments = 0;
      for (int r = 0; r < rounds; ++r) {
        double start = core_seconds();
        const analysis::StabilityJudge judge(f.scene, network);
        map = analysis::stability_map(judge, f.scene, x, f.x, y, f.y);
        seconds.push_back(core_seconds() - start);
        start = core_seconds();
        const analysis::StabilityJudge tracer(f.scene, network);
        Axis across = f.x, up = f.y;
        across.count = up.count = 16;
        analysis::ThreadedRunner alone;
        const auto boundary =
            analysis::stability_boundary(tracer, f.scene, x, across, y, up, alone);
        tracing.push_back(core_seconds() - start);
        used = boundary.evaluations;
        segments = boundary.segments.size();
      }
      // The judge of last resort, on one point in a hundred.
      core::Scene edited = f.scene;
      for (int i = 0; i < 10; ++i)
        for (int j = 0; j < 10; ++j) {
          const int a = 10 * i + (3 * j) % 10, b = 10 * j + (7 * i) % 10;
          x.set(edited, f.x.centre(a));
          y.set(edited, f.y.centre(b));
          const bool stable = analysis::judge(analysis::measured_system(edited, network)).stable();
          ++checked;
          wrong += stable != (map.stable[static_cast<std::size_t>(b) * f.x.count + a] != 0) ? 1 : 0;
        }
      const nlohmann::json& other = peer.at("maps").at(at);
      const double numpy_s = other.at("seconds"), own_s = median(seconds),
                   traced_s = median(tracing);
      const bool same = other.at("stable") == map.count && other.at("figure") == f.name;
      equal = equal && same;
      ours += own_s;
      theirs += numpy_s;
      traced += traced_s;
      evaluations += used;
      text += fmt::format(
          "  {} d={}  {:6}{} {:7.3f} {:8.4f} {:7.1f}   {:.5f} s ({} for {} segments)\n", f.name, d,
          map.count, same ? " " : "!", numpy_s, own_s, numpy_s / own_s, traced_s, used, segments);
      maps.push_back({{"figure", f.name},
                      {"d", d},
                      {"stable", map.count},
                      {"numpy_stable", other.at("stable")},
                      {"numpy_s", numpy_s},
                      {"seconds", own_s},
                      {"traced_s", traced_s},
                      {"traced_evaluations", used},
                      {"segments", segments}});
    }
  json["speedup_vs_numpy"] = theirs / ours;
  json["counts_equal"] = equal;
  json["numpy"] = peer.at("numpy");
  json["numpy_s"] = theirs;
  json["seconds"] = ours;
  json["traced_s"] = traced;
  json["tracing_speedup"] = ours / traced;
  json["tracing_fewer_evaluations"] = 160000.0 / static_cast<double>(evaluations);
  json["checked_on_the_loop"] = checked;
  json["loop_disagrees"] = wrong;
  json["maps"] = maps;
  text += fmt::format(
      "all sixteen: numpy {:.3f} s, Tandem {:.4f} s: {:.1f} times faster; counts {}\n"
      "boundaries to 1e-6: {:.4f} s, {:.1f} times less again ({:.1f} times fewer evaluations)\n"
      "{} points judged again on the running loop: {} differ\n",
      theirs, ours, theirs / ours, equal ? "equal" : "DIFFER", traced, ours / traced,
      160000.0 / static_cast<double>(evaluations), checked, wrong);
  json["roads"] = roads_table(text);
  json["accuracy"] = accuracy_table(peer.at("line"), text);
  report(json_file, text, json);
}

}  // namespace

void add_bench_analysis(CLI::App& bench) {
  CLI::App* app = bench.add_subcommand("analysis", "sixteen stability maps beside batched numpy");
  auto rounds = std::make_shared<int>(3);
  auto json_file = std::make_shared<std::string>();
  app->add_option("--rounds", *rounds, "timed rounds of each map; the median counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app->add_option("--json", *json_file, "write the result as JSON to this file; - is the output");
  app->callback([rounds, json_file] { run(*rounds, *json_file); });
}

}  // namespace tandem::bench
