#pragma once

#include <array>
#include <vector>

#include "analysis/matrix.h"
#include "core/scene.h"

/// One workstation of a linear scene over one tick: free masses and the springs between them. Axis
/// scenes, and planar ones near an attached grasp, where every spring pulls along a fixed line.
namespace tandem::analysis {

/// One coordinate of a finger or of a copy of an object; each is a free mass (or inertia).
struct Coordinate {
  int user = -1, finger = -1;  ///< of a finger; -1: of an object
  int object = -1;
  int axis = 0;  ///< 0 x, 1 y, 2 angle

  [[nodiscard]] bool is_hand() const { return finger >= 0; }
};

/// Spring and damper along one line. Its stretch is finger . (x, y) + object . (x, y, angle) for
/// small motions; it pushes each coordinate by minus its weight.
struct Spring {
  core::Gain gain;
  std::array<double, 3> finger{}, object{};
};

/// The lines of a hand's coupler: one on an axis; normal and tangent of the face held in a plane.
/// Empty where the coupler has no gain.
[[nodiscard]] std::vector<Spring> grasp_springs(const core::Scene& scene,
                                                const core::CouplerParameters& coupler, int user,
                                                int finger, int object);
/// Those between two copies: x; x, y and angle. The other copy counts against `object`.
[[nodiscard]] std::vector<Spring> coordination_springs(const core::Scene& scene,
                                                       const core::CouplerParameters& coupler);

/// x+ = a x + sum of coupled(:, i) times the couplers' force on coordinate i from other sites.
/// States: position and velocity of every coordinate, then forces under computation delay.
struct Workstation {
  int user = -1;  ///< whose copies these are; -1: the server
  std::vector<Coordinate> coordinates;
  Matrix a;
  Matrix coupled;   ///< delayed as the couplers' forces are
  Matrix external;  ///< forces from outside: the person's
  int offset = 0;   ///< of its states in the whole

  void add_hand(const core::Scene& scene, int user);
  void add_objects(const core::Scene& scene);
  [[nodiscard]] int of_finger(int user, int finger) const;  ///< its first coordinate, or -1
  [[nodiscard]] int of_object(int object) const;

  /// The weights of a spring over all coordinates here: of its ends that are here.
  [[nodiscard]] std::vector<double> ends(const Spring& s, int finger_at, int object_at) const;
};

/// Puts a workstation together: first its coordinates, then springs, then `finish`.
class WorkstationBuilder {
 public:
  WorkstationBuilder(const core::Scene& scene, Workstation& site, double mass_share);

  /// A spring whose other ends, if any, are held samples.
  void spring(const std::vector<double>& ends, const core::Gain& gain);
  /// Spring and damper of one coordinate to the ground, like a coupler.
  void to_ground(int coordinate, const core::Gain& gain);
  void finish();

 private:
  void direct(int coordinate, double stiffness, double damping);
  void free_mass(int i, double mass_share);

  const core::Scene& scene_;
  Workstation& site_;
  int delay_ = 0;
  Matrix force_;   ///< of couplers, by state
  Matrix direct_;  ///< not delayed with them: compensation, walls
};

}  // namespace tandem::analysis
