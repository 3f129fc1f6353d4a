#include "analysis/closed_form_rows.h"

#include <cstdio>

#include "analysis/closed_forms.h"
#include "analysis/drag.h"
#include "analysis/resampled.h"
#include "analysis/response.h"

namespace tandem::analysis {

namespace {

using core::Scene;

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// What every formula takes for granted and no edit of the rates brings back.
std::string why_none(const Scene& scene) {
  if (scene.space != core::Space::kAxis) return "the closed forms are for one axis";
  if (scene.architecture != core::Architecture::kCentral &&
      scene.architecture != core::Architecture::kDistributed)
    return "the closed forms are for a central scene or for whole copies";
  if (scene.users.size() != 2 || scene.objects.size() != 1)
    return "the closed forms are for two users and one object";
  for (const core::UserParameters& user : scene.users) {
    if (user.fingers.size() != 1) return "the closed forms are for one finger a user";
    const core::FingerParameters& finger = user.fingers[0];
    if (finger.hand.stiffness != 0.0 || finger.hand.damping != 0.0 || finger.damping != 0.0)
      return "the closed forms are for free hands; user " + user.name + " has springs or dampers";
  }
  if (!scene.walls.empty()) return "the closed forms are for free motion; there is a wall";
  if (scene.integrator != core::Integrator::kZeroOrderHold)
    return "the closed forms are for ZERO_ORDER_HOLD";
  if (scene.rates.latency_ticks != 0) return "the closed forms have no computation delay";
  if (scene.reconstruction.kind != core::ReconstructionKind::kHold)
    return "the closed forms are for held samples";
  return {};
}

enum class Model { kRemote, kOriginal, kBothCopies };

double sampled_damping(Scene scene, double round_trip, Model model) {
  core::NetworkModel network;
  network.set_round_trip(round_trip, scene.ticks_per_packet());
  const int user = model == Model::kRemote ? drag_user(scene) : 0;
  if (model == Model::kBothCopies)
    std::erase_if(scene.couplers, [](const auto& c) { return !c.user.empty(); });
  else
    scene = with_one_hand(scene, scene.users[user].name);
  const LiftedSystem system = resampled_system(scene, network);
  // Ports: the two fingers, then the copies of the object.
  const ForcePort port =
      model == Model::kBothCopies ? joined(system.ports[2], system.ports[3]) : system.ports[user];
  return free_motion(system, port).sampled_damping;
}

ClosedFormRow row(const Scene& scene, double round_trip, const std::string& name, Model model,
                  const std::string& about, double formula, double n, bool any_delay = false) {
  ClosedFormRow out{name,    about + ", N = 2, " + (any_delay ? "any n" : "n = " + text_of(n)),
                    formula, 0.0,
                    0.0,     {}};
  Scene assumed = scene;
  assumed.rates.packet_hz = 0.5 * scene.rates.local_hz;
  assumed.objects[0].compensation = 0.0;
  out.direct = sampled_damping(assumed, n, model);
  out.here = sampled_damping(scene, round_trip, model);
  if (scene.ticks_per_packet() != 2)
    out.outside.push_back("N is " + text_of(scene.ticks_per_packet()));
  if (!any_delay && round_trip != n)
    out.outside.push_back("the round trip is " + text_of(round_trip) + " packets");
  if (scene.objects[0].compensation != 0.0)
    out.outside.push_back("compensation is " + text_of(scene.objects[0].compensation) + " N s/m");
  return out;
}

}  // namespace

ClosedForms closed_form_rows(const Scene& scene, double round_trip) {
  ClosedForms out;
  out.why_none = why_none(scene);
  if (!out.why_none.empty()) return out;
  if (scene.architecture == core::Architecture::kCentral) {
    const std::string& user = scene.users[drag_user(scene)].name;
    for (const core::CouplerParameters& c : scene.couplers)
      if (c.user == user && c.gain.stiffness > 0.0)
        out.rows.push_back(row(scene, round_trip, "(B.10)", Model::kRemote, "remote user alone",
                               damping_b10(c.gain, scene.objects[0].mass, scene.tick()), 0.0,
                               true));
    return out;
  }
  CopiesNumbers s;
  try {
    s = copies_numbers(scene);
  } catch (const std::domain_error& e) {
    out.why_none = e.what();
    return out;
  }
  if (s.ko.stiffness <= 0.0) {
    out.why_none = "the copies are not coupled";
    return out;
  }
  out.rows = {row(scene, round_trip, "(6.3)", Model::kBothCopies, "force on both copies",
                  damping_6_3(s), 0.0),
              row(scene, round_trip, "(B.11) as printed", Model::kOriginal, "user 1 alone",
                  damping_b11(s), 1.0),
              row(scene, round_trip, "(B.11) corrected", Model::kOriginal, "user 1 alone",
                  damping_b11_corrected(s), 0.0)};
  return out;
}

}  // namespace tandem::analysis
