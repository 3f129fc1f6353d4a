#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "analysis/drag.h"
#include "analysis/grasp_response.h"
#include "analysis/response.h"
#include "cli/analyze.h"
#include "cli/commands.h"
#include "cli/picture.h"
#include "core/plane_body.h"

namespace tandem::cli {

namespace {

using nlohmann::ordered_json;

struct AdmittanceOptions {
  AnalyzeOptions common;
  std::string user, csv, picture, axis = "x";
  double from = 0.1, to = 0.0;
  int count = 60;
  bool alone = false, position = false;
};

/// Of the object, which the ideal is to feel like; none where there are only walls.
double ideal_inertia(const core::Scene& scene, bool turns) {
  if (scene.objects.empty()) return 0.0;
  const core::ObjectParameters& object = scene.objects[0];
  return turns ? 1.0 / core::plane_body_parameters(object, 0.0).inverse_inertia : object.mass;
}

/// As the figures of chapter 6 are drawn.
void draw_response(const AdmittanceOptions& o, const ordered_json& json) {
  ordered_json results{{"kind", "response"},
                       {"title", json["scene"].get<std::string>() + ": felt by user " +
                                     json["user"].get<std::string>() + ", " + o.axis},
                       {"response", json["response"]}};
  ordered_json ideal{{"name", "ideal"}}, felt{{"name", "felt"}};
  for (const ordered_json& row : json["rows"]) {
    results["omega_rad_s"].push_back(row["omega_rad_s"]);
    felt["magnitude"].push_back(row["magnitude"]);
    felt["phase_deg"].push_back(row["phase_deg"]);
    ideal["magnitude"].push_back(row["ideal_magnitude"]);
    ideal["phase_deg"].push_back(row["ideal_phase_deg"]);
  }
  results["curves"] = {std::move(ideal), std::move(felt)};
  draw_json(o.picture, "plot_figure.py", results);
}

void run(const AdmittanceOptions& o) {
  AnalyzedScene s = o.common.load();
  const bool plane = s.scene.space == core::Space::kPlane;
  if (!plane && o.axis != "x")
    throw CLI::ValidationError("--axis", o.axis + ": a scene with space AXIS has only x");
  const bool turns = o.axis == "rotation";
  const std::string user = o.user.empty() ? s.scene.users[0].name : o.user;
  const int index = core::index_of(s.scene.users, user);
  if (index < 0) {
    std::string known;
    for (const auto& u : s.scene.users) known += (known.empty() ? "" : ", ") + u.name;
    throw CLI::ValidationError("--user", "no user " + user + "; there are: " + known);
  }
  if (o.alone) s.scene = analysis::with_one_hand(s.scene, user);
  const analysis::LiftedSystem system = s.lift();
  const double nyquist = std::numbers::pi * system.packets / system.period,
               to = o.to > 0.0 ? o.to : 0.97 * nyquist;
  if (!(o.from < to) || to >= nyquist)
    throw CLI::ValidationError(
        "--to", fmt::format("from {} to {} rad/s: must go up and stay below {:.6g}, half the "
                            "packet rate",
                            o.from, to, nyquist));
  const std::vector<analysis::GraspAxis> axes =
      plane ? analysis::grasp_axes(system, s.scene, index, 0) : std::vector<analysis::GraspAxis>{};
  std::optional<analysis::Response> on_axis;
  if (!plane) {
    const auto& first = s.scene.users[static_cast<std::size_t>(index)].fingers[0].name;
    on_axis.emplace(system, analysis::port_named(system, user + "." + first));
  }
  const auto response = [&](double w) {
    if (on_axis) return (*on_axis)(w, o.position);
    return analysis::admittance(system, axes[turns ? 2 : o.axis == "y" ? 1 : 0], w, o.position);
  };
  const double inertia = ideal_inertia(s.scene, turns);
  double wall_k = 0.0, wall_b = 0.0;
  for (const core::WallParameters& wall : s.scene.walls) {
    wall_k += wall.gain.stiffness;
    wall_b += wall.gain.damping;
  }
  const char* what =
      turns ? (o.position ? "angle/torque [rad/(N m)]" : "turning/torque [rad/(N m s)]")
            : (o.position ? "X/F [m/N]" : "V/F [m/(N s)]");
  std::string text = fmt::format(
      "{}, round trip {:.6g} packets, user {}{}, {}: {}, force held and motion sampled once a "
      "packet\n{}{}       rad/s    magnitude  phase [deg]   ideal: {}\n",
      s.scene.name, o.common.delay_packets, user, o.alone ? " alone" : "", o.axis, what,
      s.assumed(), s.grasp(),
      wall_k <= 0.0   ? "mass"
      : inertia > 0.0 ? "mass at the wall"
                      : "wall");
  std::string csv = "omega_rad_s,magnitude,phase_deg,ideal_magnitude,ideal_phase_deg\n";
  ordered_json json;
  json["scene"] = s.scene.name;
  json["delay_packets"] = o.common.delay_packets;
  json["user"] = user;
  json["axis"] = o.axis;
  json["alone"] = o.alone;
  json["response"] = what;
  json["stable"] = analysis::judge(system).stable();
  if (!json["stable"].get<bool>())
    text += "  NOT stable: no steady response exists; what follows is the transfer function\n";
  json["rows"] = ordered_json::array();
  for (int i = 0; i < o.count; ++i) {
    const double w = o.from * std::pow(to / o.from, o.count == 1 ? 0.0 : i / (o.count - 1.0));
    const auto g = response(w);
    const std::complex<double> jw(0.0, w);
    const auto x = 1.0 / (jw * jw * inertia + jw * wall_b + wall_k);
    const auto ideal = o.position ? x : x * jw;
    const double phase = std::arg(g) * 180.0 / std::numbers::pi,
                 ideal_phase = std::arg(ideal) * 180.0 / std::numbers::pi;
    text += fmt::format("{:12.6g} {:12.6g} {:9.2f}   {:12.6g} {:9.2f}\n", w, std::abs(g), phase,
                        std::abs(ideal), ideal_phase);
    csv += fmt::format("{},{},{},{},{}\n", w, std::abs(g), phase, std::abs(ideal), ideal_phase);
    json["rows"].push_back({{"omega_rad_s", w},
                            {"magnitude", number(std::abs(g))},
                            {"phase_deg", number(phase)},
                            {"ideal_magnitude", std::abs(ideal)},
                            {"ideal_phase_deg", ideal_phase}});
  }
  o.common.tell(o.csv, csv, text, json);
  if (!o.picture.empty()) draw_response(o, json);
}

}  // namespace

void add_analyze_admittance(CLI::App& analyze) {
  CLI::App* command = analyze.add_subcommand(
      "admittance", "frequency response felt by a hand (6.1) beside the ideal mass or wall");
  auto o = std::make_shared<AdmittanceOptions>();
  o->common.add(*command);
  command->add_option("--user", o->user, "whose hand; default: the first user's");
  command->add_option("--axis", o->axis, "in a plane: x, y (shared by the fingers) or rotation")
      ->check(CLI::IsMember({"x", "y", "rotation"}))
      ->capture_default_str();
  command->add_flag("--alone", o->alone, "the other hands do not touch (thesis chapter 6)");
  command->add_flag("--position", o->position, "X/F instead of V/F (Fig 6.5)");
  command->add_option("--from", o->from, "lowest frequency [rad/s]")
      ->check(between(1e-9, 1e9))
      ->capture_default_str();
  command->add_option("--to", o->to, "highest [rad/s]; default just below half the packet rate")
      ->check(between(1e-9, 1e9));
  command->add_option("--count", o->count, "frequencies, evenly on a logarithmic scale")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  add_csv(*command, o->csv, "write the response to this file");
  command->add_option("--picture", o->picture, "draw it: a .svg or .png file")
      ->check(picture_file, "", "a picture");
  on_call(*command, o, run);
}

}  // namespace tandem::cli
