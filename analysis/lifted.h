#pragma once

#include <complex>
#include <string>
#include <vector>

#include "analysis/matrix.h"
#include "analysis/symmetry.h"
#include "core/network_model.h"
#include "core/scene.h"

/// A session as one linear map over a packet period, packets in flight included, and its judgement.
/// Where the ratio of the rates is not whole, over one repeat of the packet ticks: the product of
/// the maps of its packet periods, so that the size stays that of the session.
/// Three roads lead to the map: measured from the running loop (`measured_system`, the judge: it
/// cannot differ from the run time), resampled (resampled.h, for speed), and Araki and Yamamoto's,
/// which is a test.
namespace tandem::analysis {

/// Where a force of one newton on a finger (or object) enters, and what it moves.
struct ForcePort {
  std::string name;
  std::vector<double> push;  ///< change of every state over a period by 1 N held over it
  int position = -1;         ///< index of the state
  int velocity = -1;
};

/// One packet period of a repeat of several.
struct PacketPeriod {
  Matrix map;                             ///< columns: states at its start, rows: at its end
  std::vector<std::vector<double>> push;  ///< of each port, by 1 N held over it
  int ticks = 0;
};

struct LiftedSystem {
  Matrix transition;  ///< true transition times 2^-scale
  double scale = 0.0;
  double period = 0.0;               ///< what is lifted over: packet period T_t, or repeat [s]
  int packets = 1;                   ///< in it
  std::vector<double> velocities;    ///< 1 for each velocity state, else 0
  std::vector<Symmetry> symmetries;  ///< common motions that may be kept
  /// Declares springs to the ground: then nothing may be removed.
  bool grounded = false;
  /// How exactly a symmetry must be kept, relative to the largest effect.
  double tolerance = 1e-10;
  std::vector<ForcePort> ports;  ///< one a finger, user by user
  /// Where packets > 1: the different packet periods, and which follows which.
  std::vector<PacketPeriod> periods;
  std::vector<int> order;

  [[nodiscard]] int states() const { return transition.rows; }
};

/// What was assumed to get a linear scene: contacts attached, no saturation, no encoder...
struct LinearScene {
  core::Scene scene;
  std::vector<std::string> assumptions;
};
[[nodiscard]] LinearScene linear_scene(const core::Scene& scene);

/// Whether something holds the scene to the ground, so that it cannot move as a whole.
[[nodiscard]] bool has_spring_to_ground(const core::Scene& scene);

/// The map measured on the running loop: each state set to one in turn, one packet period run.
/// Throws std::domain_error where the packet ticks repeat only after more than 200000 packets.
/// `scene` must be linear (linear_scene); superposition is checked and std::domain_error thrown
/// where it fails. Axis and plane.
[[nodiscard]] LiftedSystem measured_system(const core::Scene& scene,
                                           const core::NetworkModel& network);

struct Judgement {
  /// Largest eigenvalue modulus over a packet period (geometric mean over those of a repeat) with
  /// the common motions taken out; infinite where even scaled powers overflow.
  double radius = 0.0;
  double log2_radius = 0.0;  ///< finite also where radius overflows
  /// Of what is left, over LiftedSystem::period (the modulus of the whole repeat), largest first.
  std::vector<std::complex<double>> eigenvalues;
  std::vector<std::string> removed;  ///< taken out, exactly
  int parts = 1;                     ///< pieces that do not feel each other
  [[nodiscard]] bool stable() const { return radius < 1.0; }
};

/// Takes out the common motions that the map keeps exactly, then finds the largest modulus. The
/// pieces of a scene that do not feel each other are judged one by one. Throws std::domain_error
/// if a scene without springs to the ground does not keep its translation: its laws are wrong.
[[nodiscard]] Judgement judge(const LiftedSystem& system);

/// The eigenvalues per packet period: over a repeat of several, the roots whose phase is that by
/// which the hands turn from packet to packet, below half a turn each.
[[nodiscard]] std::vector<std::complex<double>> packet_modes(const LiftedSystem& system,
                                                             const Judgement& judged);

}  // namespace tandem::analysis
