#pragma once

#include <array>
#include <string_view>

/// The cases of `tandem bench error`: plain numbers that Tandem, every peer and the reference read.
/// Nothing of Tandem is included here, because the peers' programs share this file.
namespace tandem::bench {

enum class Case {
  kMasses,     ///< hand and object, two free masses on one coupler; the object is thrown
  kHands,      ///< two hands, free masses under constant forces, carry an object between couplers
  kWall,       ///< an object flies into a spring-damper wall that never pulls, and leaves it
  kStickSlip,  ///< Rabinowicz: a mass on a rough floor drawn by a spring whose end moves steadily
  kSlide,      ///< a box slides on the ground under Coulomb friction until it rests
  kSpin,       ///< a box with three different moments spins freely in space
};

/// One curve of the diagrams: a case at one stiffness.
struct ErrorPoint {
  Case which;
  std::string_view name;
  double stiffness;  ///< of couplers or wall; stick-slip: Tandem's tangential spring [N/m]
  double damping;    ///< beside it [N s/m]
  double seconds;    ///< simulated
};

inline constexpr std::array kErrorPoints{
    ErrorPoint{Case::kMasses, "masses", 300.0, 10.0, 0.25},
    ErrorPoint{Case::kMasses, "masses", 1000.0, 10.0, 0.25},
    ErrorPoint{Case::kMasses, "masses", 3000.0, 10.0, 0.25},
    ErrorPoint{Case::kMasses, "masses", 10000.0, 10.0, 0.25},
    ErrorPoint{Case::kMasses, "masses", 30000.0, 10.0, 0.25},
    ErrorPoint{Case::kHands, "hands", 300.0, 10.0, 0.25},
    ErrorPoint{Case::kHands, "hands", 1000.0, 10.0, 0.25},
    ErrorPoint{Case::kHands, "hands", 3000.0, 10.0, 0.25},
    ErrorPoint{Case::kHands, "hands", 10000.0, 10.0, 0.25},
    ErrorPoint{Case::kHands, "hands", 30000.0, 10.0, 0.25},
    ErrorPoint{Case::kWall, "wall", 1000.0, 5.0, 0.25},
    ErrorPoint{Case::kWall, "wall", 3000.0, 5.0, 0.25},
    ErrorPoint{Case::kWall, "wall", 10000.0, 5.0, 0.25},
    ErrorPoint{Case::kWall, "wall", 30000.0, 5.0, 0.25},
    ErrorPoint{Case::kStickSlip, "stick_slip", 3000.0, 20.0, 1.0},
    ErrorPoint{Case::kStickSlip, "stick_slip", 30000.0, 20.0, 1.0},
    ErrorPoint{Case::kSlide, "slide", 0.0, 0.0, 0.25},
    ErrorPoint{Case::kSpin, "spin", 0.0, 0.0, 1.0},
};

/// Steps a second, of everyone.
inline constexpr std::array kErrorRates{256, 512, 1024, 2048, 4096, 8192, 16384};

/// States are compared at multiples of 1/256 s: the stiffest coupler swings in 10 ms.
inline constexpr int kGridRate = 256;

inline constexpr double kHandMass = 0.1, kObjectMass = 0.4;      // [kg]
inline constexpr double kThrown = 0.1;                           // masses: object [m/s]
inline constexpr double kPushed[2] = {0.8, -0.3};                // hands: on each [N]
inline constexpr double kGap = 0.0103, kFlight = 0.3;            // wall: way to it [m], speed [m/s]
inline constexpr double kDrawSpring = 100.0, kDrawSpeed = 0.02;  // stick-slip [N/m], [m/s]
inline constexpr double kNormalForce = 2.0;                      // [N]
inline constexpr double kSticks = 0.5, kSlips = 0.3;             // mu_s, mu_k
inline constexpr double kSlideFriction = 0.3, kGravity = 9.81;   // mu, [m/s^2]
inline constexpr double kSlideSpeed[2] = {0.4, 0.3};             // [m/s]
inline constexpr double kBoxSize = 0.1;                          // edge, slide [m]
inline constexpr double kMoments[3] = {4.0e-4, 9.0e-4, 12.0e-4};  // spin [kg m^2]
inline constexpr double kSpin[3] = {6.0, 4.0, 8.0};               // spin, in the body [rad/s]

/// Numbers in one sample of the state:
///   masses      p v of the hand, p v of the object          hands       p v of 1, object, 2
///   wall        p v                                         stick_slip  p v
///   slide       x y vx vy                                   spin        q (w x y z), omega in W
[[nodiscard]] constexpr int sample_width(Case which) {
  switch (which) {
    case Case::kMasses:
      return 4;
    case Case::kHands:
      return 6;
    case Case::kWall:
    case Case::kStickSlip:
      return 2;
    case Case::kSlide:
      return 4;
    case Case::kSpin:
      return 7;
  }
  return 0;
}

[[nodiscard]] constexpr int sample_count(const ErrorPoint& point) {
  return static_cast<int>(point.seconds * kGridRate);
}

}  // namespace tandem::bench
