#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "core/allocation_counter.h"
#include "devices/framed_device.h"
#include "devices/open_device.h"
#include "devices/recorded_hand.h"
#include "devices/simulated_hand.h"
#include "tests/recording/scratch_folder.h"

namespace tandem::devices {
namespace {

using test::ScratchFolder;

constexpr double kT = 1.0 / 1024.0;

core::FingerParameters free_finger() {
  core::FingerParameters finger;
  finger.name = "thumb";
  finger.position = {0.1, 0.2, 0.3};
  return finger;
}

core::FingerParameters held_finger() {
  core::FingerParameters finger = free_finger();
  finger.hand = {.stiffness = 400.0, .damping = 12.0};
  return finger;
}

DeviceSample read_at(HapticDevice& device, std::int64_t slot) {
  DeviceSample sample;
  EXPECT_EQ(device.read(slot, sample), DeviceStatus::kOk);
  return sample;
}

// x = F t^2 / (2 m): exact in a zero-order hold, up to rounding over 1024 steps.
TEST(SimulatedHandDevice, AFreeHandFallsUnderAConstantForceAsGalileoSays) {
  SimulatedHandDevice<core::Vec2> device(kT, 0.2, free_finger(), nullptr);
  for (std::int64_t slot = 0; slot < 1024; ++slot) {
    read_at(device, slot);
    ASSERT_EQ(device.write({.force = {0.5, -1.0, 9.0}}), DeviceStatus::kOk);
  }
  const DeviceSample sample = read_at(device, 1024);
  EXPECT_NEAR(sample.position.x, 0.1 + 0.5 * 2.5, 1e-12);
  EXPECT_NEAR(sample.position.y, 0.2 - 0.5 * 5.0, 1e-12);
  EXPECT_EQ(sample.position.z, 0.0);  // a plane has none
  EXPECT_NEAR(sample.velocity.x, 2.5, 1e-12);
  EXPECT_TRUE(sample.has_velocity);
  EXPECT_EQ(device.info().position_dof, 2);
}

TEST(SimulatedHandDevice, SkippedSlotsAreLivedThroughWithTheLastCommand) {
  SimulatedHandDevice<double> every(kT, 0.1, held_finger(), nullptr);
  SimulatedHandDevice<double> some(kT, 0.1, held_finger(), nullptr);
  for (std::int64_t slot = 0; slot <= 300; ++slot) {
    const DeviceSample a = read_at(every, slot);
    const double force = std::floor(static_cast<double>(slot) / 10.0) * 0.1;
    ASSERT_EQ(every.write({.force = {force, 0, 0}}), DeviceStatus::kOk);
    if (slot % 10 != 0) continue;
    const DeviceSample b = read_at(some, slot);
    ASSERT_EQ(a.position.x, b.position.x) << slot;  // same steps, same bits
    ASSERT_EQ(some.write({.force = {force, 0, 0}}), DeviceStatus::kOk);
  }
}

TEST(SimulatedHandDevice, StartsAtTheSlotOfItsFirstReadAndOutlivesALongSilence) {
  SimulatedHandDevice<double> device(kT, 0.1, free_finger(), nullptr);
  EXPECT_EQ(read_at(device, 1'000'000).position.x, 0.1);
  ASSERT_EQ(device.write({.force = {1.0, 0, 0}}), DeviceStatus::kOk);
  EXPECT_TRUE(std::isfinite(read_at(device, std::int64_t{1} << 40).position.x));  // and soon
}

TEST(SimulatedHandDevice, AfterStopThereIsNoForce) {
  SimulatedHandDevice<double> device(kT, 0.1, free_finger(), nullptr);
  read_at(device, 0);
  ASSERT_EQ(device.write({.force = {1.0, 0, 0}}), DeviceStatus::kOk);
  device.stop();
  device.stop();
  EXPECT_EQ(device.write({.force = {1.0, 0, 0}}), DeviceStatus::kStopped);
  EXPECT_EQ(read_at(device, 100).position.x, 0.1);
}

TEST(SimulatedHandDevice, ACommandThatIsNotFiniteIsRefusedAndLeavesNoForce) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    SimulatedHandDevice<core::Vec3> device(kT, 0.1, free_finger(), nullptr);
    read_at(device, 0);
    ASSERT_EQ(device.write({.force = {1.0, 0, 0}}), DeviceStatus::kOk);
    EXPECT_EQ(device.write({.force = {0, bad, 0}}), DeviceStatus::kNotFinite);
    EXPECT_EQ(read_at(device, 50).position, core::Vec3(0.1, 0.2, 0.3));
  }
}

TEST(SimulatedHandDevice, AnEncoderGivesWholeStepsAndNoVelocity) {
  core::DeviceParameters parameters;
  parameters.encoder_step = 0.001;
  parameters.max_force = 3.3;
  SimulatedHandDevice<double> device(kT, 0.1, free_finger(), &parameters);
  read_at(device, 0);
  ASSERT_EQ(device.write({.force = {0.7, 0, 0}}), DeviceStatus::kOk);
  for (std::int64_t slot = 1; slot < 200; ++slot) {
    const DeviceSample sample = read_at(device, slot);
    const double steps = sample.position.x / 0.001;
    ASSERT_NEAR(steps, std::round(steps), 1e-9);
    ASSERT_FALSE(sample.has_velocity);
  }
  EXPECT_EQ(device.info().max_force, 3.3);
  EXPECT_EQ(device.info().resolution, 0.001);
}

std::shared_ptr<const RecordedPath> ramp_then_rest() {
  return std::make_shared<const RecordedPath>(
      std::vector<PathSample>{{0.0, {0, 0, 0}}, {1.0, {0.02, 0, 0}}, {1.001, {0.02, 0, 0}}},
      Interpolation::kLinear, PathEnd::kHold, 0.0);
}

TEST(RecordedHandDevice, ForceDoesNotMoveIt) {
  RecordedHandDevice device(kT, ramp_then_rest(), {0.1, 0.2, 0.0}, nullptr, "ramp");
  for (std::int64_t slot = 0; slot <= 2048; ++slot) {
    const DeviceSample sample = read_at(device, slot);
    const double t = static_cast<double>(slot) / 1024.0;
    ASSERT_NEAR(sample.position.x, 0.1 + 0.02 * std::min(t, 1.0), 1e-15);
    ASSERT_EQ(sample.position.y, 0.2);
    ASSERT_EQ(device.write({.force = {100.0, 100.0, 0}}), DeviceStatus::kOk);
  }
  EXPECT_EQ(device.write({.force = {NAN, 0, 0}}), DeviceStatus::kNotFinite);
  device.stop();
  EXPECT_EQ(device.write({}), DeviceStatus::kStopped);
}

// At rest the spring balances the command: the hand stands F / K away from the recording.
TEST(DrivenHandDevice, FollowsTheRecordingAndYieldsToForceByItsStiffness) {
  DrivenHandDevice<double> device(kT, 0.1, held_finger(), nullptr, ramp_then_rest(), "ramp");
  for (std::int64_t slot = 0; slot < 3 * 1024; ++slot) {
    read_at(device, slot);
    ASSERT_EQ(device.write({.force = {2.0, 0, 0}}), DeviceStatus::kOk);
  }
  // 2 s after the ramp: e^(-60 * 2) of the transient is left, nothing.
  EXPECT_NEAR(read_at(device, 3 * 1024).position.x, 0.1 + 0.02 + 2.0 / 400.0, 1e-12);
}

// A ramp of velocity v: spring and damper go with it, so the hand lags by nothing once settled.
TEST(DrivenHandDevice, LagsNoRampOnceSettled) {
  const auto path = std::make_shared<const RecordedPath>(
      std::vector<PathSample>{{0.0, {0, 0, 0}}, {10.0, {0.5, 0, 0}}}, Interpolation::kLinear,
      PathEnd::kHold, 0.0);
  DrivenHandDevice<double> device(kT, 0.1, held_finger(), nullptr, path, "ramp");
  read_at(device, 0);
  const double earlier = read_at(device, 3 * 1024).position.x;
  const DeviceSample sample = read_at(device, 4 * 1024);
  EXPECT_NEAR(sample.position.x - earlier, 0.05, 1e-12);  // in one second; rounding
  // Within a tick the speed swings, because the target stands still: K T / (2 B) of it at most.
  EXPECT_NEAR(sample.velocity.x, 0.05, 0.05 * 400.0 * kT / (2.0 * 12.0));
  // The target is held over a tick while the hand moves on: half a tick of travel.
  EXPECT_NEAR(sample.position.x, 0.1 + 0.20, 0.05 * kT);
}

TEST(Devices, ReadAndWriteDoNotAllocate) {
  ASSERT_TRUE(core::allocation_hook_linked());
  DrivenHandDevice<core::Vec3> driven(kT, 0.1, held_finger(), nullptr, ramp_then_rest(), "a");
  RecordedHandDevice recorded(kT, ramp_then_rest(), {}, nullptr, "b");
  SimulatedHandDevice<core::Vec3> simulated(kT, 0.1, held_finger(), nullptr);
  const std::uint64_t before = core::counted_allocations();
  {
    const core::CountAllocations counted;
    for (HapticDevice* device :
         {static_cast<HapticDevice*>(&driven), static_cast<HapticDevice*>(&recorded),
          static_cast<HapticDevice*>(&simulated)}) {
      for (std::int64_t slot = 0; slot < 1000; ++slot) {
        read_at(*device, slot);
        static_cast<void>(device->write({.force = {1, 0, 0}}));
      }
      device->stop();
    }
  }
  EXPECT_EQ(core::counted_allocations(), before);
}

core::Scene scene_with(const core::DeviceParameters& device, const core::FingerParameters& finger) {
  core::Scene scene;
  scene.space = core::Space::kPlane;
  scene.devices.push_back(device);
  core::UserParameters user;
  user.fingers.push_back(finger);
  user.fingers.back().device = device.name;
  scene.users.push_back(user);
  return scene;
}

TEST(OpenDevice, OpensWhatTheSceneDeclares) {
  const ScratchFolder folder;
  std::ofstream(folder / "hand.csv") << "t,x\n0,0\n1,10\n2,20\n";
  core::DeviceParameters device;
  device.name = "touch1";
  EXPECT_EQ(open_device(scene_with(device, free_finger()), 0, 0)->info().name, "simulated hand");
  device.kind = core::DeviceKind::kRecorded;
  device.file = (folder / "hand.csv") + "?time=t,x=x:mm";
  const auto kinematic = open_device(scene_with(device, free_finger()), 0, 0);
  EXPECT_EQ(kinematic->info().name.substr(0, 13), "recorded hand");
  EXPECT_NEAR(read_at(*kinematic, 1024).position.x, 0.1 + 0.010, 1e-15);
  const auto driving = open_device(scene_with(device, held_finger()), 0, 0);
  EXPECT_EQ(driving->info().name.substr(0, 24), "simulated hand driven by");
  device.file += ",mode=kinematic";
  EXPECT_EQ(open_device(scene_with(device, held_finger()), 0, 0)->info().name.substr(0, 13),
            "recorded hand");
}

/// Measures what it is told, remembers what it is asked for.
class Mechanism final : public HapticDevice {
 public:
  DeviceInfo info_;
  DeviceSample sample;
  DeviceStatus status = DeviceStatus::kOk;
  DeviceCommand* asked = nullptr;
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] DeviceStatus read(std::int64_t, DeviceSample& out) noexcept override {
    if (status == DeviceStatus::kOk) out = sample;
    return status;
  }
  [[nodiscard]] DeviceStatus write(const DeviceCommand& command) noexcept override {
    *asked = command;
    return status;
  }
  void stop() noexcept override {}
};

// A quarter turn around z: the device's x is the scene's y, its y the scene's -x.
TEST(FramedDevice, TurnsMotionIntoTheSceneAndForceBack) {
  DeviceCommand asked;
  auto inner = std::make_unique<Mechanism>();
  Mechanism& mechanism = *inner;
  mechanism.asked = &asked;
  mechanism.info_.workspace_min = {0, 0, 0};
  mechanism.info_.workspace_max = {1, 2, 3};
  const double h = std::sqrt(0.5);
  FramedDevice device(std::move(inner), {{10, 20, 30}, core::Quat(h, 0, 0, h)});
  mechanism.sample.position = {1, 2, 3};
  mechanism.sample.velocity = {4, 5, 6};
  mechanism.sample.has_velocity = true;
  mechanism.sample.buttons = 5;
  const DeviceSample seen = read_at(device, 0);
  EXPECT_LT(glm::length(seen.position - Vec3{8, 21, 33}), 1e-12);
  EXPECT_LT(glm::length(seen.velocity - Vec3{-5, 4, 6}), 1e-12);
  EXPECT_EQ(seen.buttons, 5u);
  EXPECT_LT(glm::length(device.info().workspace_min - Vec3{8, 20, 30}), 1e-12);
  EXPECT_LT(glm::length(device.info().workspace_max - Vec3{10, 21, 33}), 1e-12);
  const Vec3 force{0.5, -1.5, 2.5};
  EXPECT_EQ(device.write({.force = force}), DeviceStatus::kOk);
  EXPECT_LT(glm::length(asked.force - Vec3{-1.5, -0.5, 2.5}), 1e-12);
  EXPECT_NEAR(glm::dot(asked.force, mechanism.sample.velocity), glm::dot(force, seen.velocity),
              1e-12)
      << "a frame makes no power";
}

TEST(FramedDevice, KeepsTheSampleWhenTheDeviceDoesNotAnswer) {
  auto inner = std::make_unique<Mechanism>();
  inner->status = DeviceStatus::kDisconnected;
  FramedDevice device(std::move(inner), {{1, 2, 3}, core::Quat(1, 0, 0, 0)});
  DeviceSample sample;
  sample.position = {7, 8, 9};
  EXPECT_EQ(device.read(0, sample), DeviceStatus::kDisconnected);
  EXPECT_EQ(sample.position.x, 7.0);
}

TEST(OpenDevice, SaysWhichDeviceWhichFieldAndWhatToDo) {
  core::DeviceParameters device;
  device.name = "touch1";
  const auto refused = [&] {
    try {
      static_cast<void>(open_device(scene_with(device, free_finger()), 0, 0));
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string("nothing was thrown");
  };
  device.kind = core::DeviceKind::kRecorded;
  EXPECT_NE(refused().find("device \"touch1\": file is empty"), std::string::npos) << refused();
  device.file = "/no/such.csv?time=t,x=x";
  EXPECT_NE(refused().find("\"/no/such.csv\" cannot be read"), std::string::npos) << refused();
  device.file = "/no/such.csv?time=t,x=x,mode=driving";
  EXPECT_NE(refused().find("hand.stiffness of finger \"thumb\" is 0"), std::string::npos)
      << refused();
}

}  // namespace
}  // namespace tandem::devices
