#pragma once

#include <complex>
#include <string>
#include <vector>

#include "analysis/matrix.h"
#include "analysis/symmetry.h"
#include "core/network_model.h"
#include "core/scene.h"

/// A session as one linear map over a packet period, packets in flight included, and its judgement.
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

struct LiftedSystem {
  Matrix transition;  ///< true transition times 2^-scale
  double scale = 0.0;
  double period = 0.0;               ///< packet period T_t [s]
  std::vector<double> velocities;    ///< 1 for each velocity state, else 0
  std::vector<Symmetry> symmetries;  ///< common motions that may be kept
  /// Declares springs to the ground: then nothing may be removed.
  bool grounded = false;
  /// How exactly a symmetry must be kept, relative to the largest effect.
  double tolerance = 1e-10;
  std::vector<ForcePort> ports;  ///< one a finger, user by user

  [[nodiscard]] int states() const { return transition.rows; }
};

/// What was assumed to get a linear scene: contacts attached, no saturation, no encoder...
struct LinearScene {
  core::Scene scene;
  std::vector<std::string> assumptions;
};
[[nodiscard]] LinearScene linear_scene(const core::Scene& scene);

/// The map measured on the running loop: each state set to one in turn, one packet period run.
/// `scene` must be linear (linear_scene); superposition is checked and std::domain_error thrown
/// where it fails. Axis and plane.
[[nodiscard]] LiftedSystem measured_system(const core::Scene& scene,
                                           const core::NetworkModel& network);

struct Judgement {
  /// Largest eigenvalue modulus over a packet period with the common motions taken out; infinite
  /// where even scaled powers overflow.
  double radius = 0.0;
  double log2_radius = 0.0;                       ///< finite also where radius overflows
  std::vector<std::complex<double>> eigenvalues;  ///< of what is left, largest first
  std::vector<std::string> removed;               ///< taken out, exactly
  int parts = 1;                                  ///< pieces that do not feel each other
  [[nodiscard]] bool stable() const { return radius < 1.0; }
};

/// Takes out the common motions that the map keeps exactly, then finds the largest modulus. The
/// pieces of a scene that do not feel each other are judged one by one. Throws std::domain_error
/// if a scene without springs to the ground does not keep its translation: its laws are wrong.
[[nodiscard]] Judgement judge(const LiftedSystem& system);

}  // namespace tandem::analysis
