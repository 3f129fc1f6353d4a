#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/packet_slots.h"
#include "core/vec.h"

/// The plain form of a session's description. `scene/` fills it from a text file and validates it;
/// laws copy what they need out of it before the session starts, so nothing here is real-time.
namespace tandem::core {

inline constexpr int kMaxUsers = 8;
inline constexpr int kMaxFingers = 4;  ///< per user
inline constexpr int kMaxObjects = 4;
inline constexpr int kMaxWalls = 8;

/// Which motions exist at all. What a space lacks is not computed.
enum class Space { kAxis, kPlane, kSpace };

enum class Architecture {
  kSingle,            ///< one user, no network
  kCentral,           ///< a server simulates the objects and returns forces
  kDistributed,       ///< every hand acts on every copy; copies carry the full mass (the thesis)
  kDistributedSplit,  ///< every hand acts on its own copy of mass m/N; couplers join the copies
};

enum class Integrator {
  kZeroOrderHold,      ///< exact for a force held over the tick; walls: core/mean_contact.h
  kSemiImplicitEuler,  ///< v, then x with the new v
  kExplicitEuler,      ///< x with the old v (thesis 7.2.3)
  kExactCoupler,  ///< axis: object and couplers to the own hand together, see core/axis_world.h
};

enum class ReconstructionKind { kHold, kExtrapolate };

/// Spring and damper of one direction.
struct Gain {
  double stiffness = 0.0;  ///< [N/m] or [N m/rad], >= 0
  double damping = 0.0;    ///< [N s/m] or [N m s/rad], >= 0

  [[nodiscard]] bool any() const noexcept { return stiffness > 0.0 || damping > 0.0; }
};

struct Rates {
  double local_hz = 1024.0;  ///< force loop of every workstation
  double packet_hz = 128.0;  ///< packets of every sender
  int latency_ticks = 0;     ///< computation delay z^-1 between hand sample and force [ticks]
};

/// How a contact between two things pushes: normal penalty, tangential spring, friction cone.
struct FrictionParameters {
  double static_coefficient = 0.0;    ///< mu_s; 0 with dynamic 0: no friction, nothing computed
  double dynamic_coefficient = 0.0;   ///< mu_k <= mu_s
  double threshold_velocity = 0.005;  ///< v_tr, slide returns to pre-slide below it [m/s]
};

/// Contact of fingers with objects (thesis 7.2.2).
struct ContactParameters {
  /// True: couplers are bilateral and always attached, at the contact point of the initial grasp;
  /// no contact test, cone or pulses exist. Axis scenes and linearised grasps use this.
  bool attached = true;
  FrictionParameters friction;
  bool moment_cancellation = false;  ///< braking pulses at first touch (7.1, 7.2)
  double pulse_force = 0.0;          ///< F_max of the pulses [N]
};

enum class Shape { kPoint, kBox, kSphere };

struct ObjectParameters {
  std::string name;
  Shape shape = Shape::kPoint;  ///< axis: point; plane: box; space: box or sphere
  Vec3 size{0.0};               ///< full edge lengths of a box [m]; plane uses x, y
  double radius = 0.0;          ///< of a sphere [m]
  double mass = 0.4;            ///< whole mass, also when copies share it [kg]
  Vec3 inertia{0.0};            ///< principal moments [kg m^2]; plane uses z; 0: uniform density
  Vec3 position{0.0};           ///< initial centre [m]
  double angle = 0.0;           ///< plane: initial rotation [rad]
  Quat orientation{1.0, 0.0, 0.0, 0.0};   ///< space: initial orientation
  Vec3 velocity{0.0};                     ///< initial velocity of the centre [m/s]
  Vec3 angular_velocity{0.0};             ///< initial angular velocity [rad/s]; plane uses z
  double ground_friction = 0.0;           ///< Coulomb coefficient against sliding on the ground
  double ground_friction_rotation = 0.0;  ///< Coulomb coefficient against spinning on the ground
  double compensation = 0.0;           ///< negative damping of each copy, linear axes [N s/m], >= 0
  double compensation_rotation = 0.0;  ///< the same for rotation [N m s/rad]
};

/// A plane that holds back objects, fingers or both; its normal points to the free side.
struct WallParameters {
  std::string name;
  Vec3 point{0.0};   ///< any point of the surface [m]
  Vec3 normal{0.0};  ///< unit vector
  Gain gain;         ///< normal direction
  Gain tangential;   ///< plane, space
  FrictionParameters friction;
  bool attached = false;  ///< axis: bilateral spring for linear analysis, no contact test
  bool touches_objects = true;
  bool touches_fingers = false;
};

/// One virtual coupler. With `user` set it joins that user's fingers to the object; without, it
/// holds `copy`'s copy of the object to the copies of the others.
struct CouplerParameters {
  std::string name;  ///< k1, k2; k11, k22, k12, k21, ko1, ko2 in the shipped scenes
  std::string object;
  std::string user;  ///< whose hand acts; empty: coordination of copies
  std::string copy;  ///< user whose copy it acts on; empty: the server's (or only) object
  Gain gain;         ///< axis: the only gain; plane, space: normal, or coordination of x, y, z
  Gain tangential;   ///< hands in plane and space
  Gain rotation;     ///< coordination in plane and space
};

/// One stretch of a target path, all coordinates blended smoothly; see core/target_path.h.
struct Keyframe {
  double time = 0.0;   ///< [s] from the start
  Vec3 position{0.0};  ///< offset from the finger's initial position [m]
};

/// amplitude * sin(omega (t - start)) along `direction`, between start and end.
struct SinePart {
  double start = 0.0, end = 1e30;  ///< [s]
  double amplitude = 0.0;          ///< [m] for paths, [N] for forces
  double omega = 0.0;              ///< [rad/s]
  Vec3 direction{0.0};
  bool positive_part_only = false;  ///< max(0, ...)
};

/// What a simulated hand wants: where its muscle spring pulls to, and force it adds of itself.
struct FingerIntent {
  std::vector<Keyframe> path;        ///< empty: stays at its initial position
  std::vector<SinePart> path_sines;  ///< added to the path
  Vec3 force{0.0};                   ///< constant force by the person [N]
  std::vector<SinePart> force_sines;
};

struct FingerParameters {
  std::string name;
  std::string device;
  Vec3 position{0.0};    ///< initial [m]
  double radius = 0.0;   ///< of the finger sphere [m]; plane and axis: 0 is a point
  Gain hand;             ///< simulated hand: spring and damper to its path; 0: free mass
  double damping = 0.0;  ///< simulated hand: damper to the ground [N s/m]
  FingerIntent intent;
};

struct UserParameters {
  std::string name;
  double mass = 0.1;   ///< hand and device, each finger [kg]
  bool local = false;  ///< central: this user's workstation is the server
  std::vector<FingerParameters> fingers;
};

enum class DeviceKind { kSimulated, kRecorded, kPointer };

/// Local to a workstation: not part of the hash.
struct DeviceParameters {
  std::string name;
  DeviceKind kind = DeviceKind::kSimulated;
  double max_force = 0.0;           ///< [N]; 0: not limited (virtual time only)
  double max_slew = 0.0;            ///< [N/s]; 0: not limited
  double encoder_step = 0.0;        ///< position resolution [m]; 0: exact
  double friction = 0.0;            ///< Coulomb friction of the mechanism [N]
  double velocity_cutoff_hz = 0.0;  ///< low-pass of the velocity estimate; 0: the device's own
                                    ///< velocity, or the plain difference where it has none
  std::string file;                 ///< recorded: what to play
};

struct ReconstructionParameters {
  ReconstructionKind kind = ReconstructionKind::kHold;
  double horizon = 0.050;  ///< extrapolate: full up to this age [s]
  double decay = 0.030;    ///< extrapolate: time constant of the decay beyond it [s]
};

/// What silence of a peer does to the force it causes. Absent in axis scenes: held for ever.
struct SilenceParameters {
  double timeout = 0.100;  ///< silence before the fade starts [s]
  double fade = 0.100;     ///< fade to zero [s], raised cosine
  double rejoin = 0.400;   ///< ramp in again, from zero stretch [s]
};

/// What everyone in a session must agree on, and beside it the devices, which are local.
struct Scene {
  int version = 1;
  std::string name;
  std::string description;
  Space space = Space::kAxis;
  Architecture architecture = Architecture::kDistributed;
  Rates rates;
  Integrator integrator = Integrator::kZeroOrderHold;
  ReconstructionParameters reconstruction;
  std::optional<SilenceParameters> silence;
  ContactParameters contact;
  double gravity = 9.81;  ///< for ground friction, and in space as weight along -z if `weight`
  bool weight = false;    ///< space: objects have weight
  std::vector<ObjectParameters> objects;
  std::vector<WallParameters> walls;
  std::vector<CouplerParameters> couplers;
  std::vector<UserParameters> users;
  std::vector<DeviceParameters> devices;

  [[nodiscard]] double tick() const { return 1.0 / rates.local_hz; }  ///< T [s]
  [[nodiscard]] PacketSlots packet_slots() const noexcept {
    return PacketSlots::of(rates.local_hz, rates.packet_hz);
  }
  /// Ticks from packet to packet: N where the ratio of the rates is whole, else the mean.
  [[nodiscard]] double ticks_per_packet() const noexcept {
    return packet_slots().ticks_per_packet();
  }
  /// The same in whole ticks, rounded up: packets are never further apart.
  [[nodiscard]] int most_ticks_per_packet() const noexcept {
    const PacketSlots slots = packet_slots();
    return static_cast<int>((slots.ticks + slots.packets - 1) / slots.packets);
  }
};

/// Index of the entry with this name, or -1.
template <typename Entry>
[[nodiscard]] int index_of(const std::vector<Entry>& entries, const std::string& name) {
  for (std::size_t i = 0; i < entries.size(); ++i)
    if (entries[i].name == name) return static_cast<int>(i);
  return -1;
}

}  // namespace tandem::core
