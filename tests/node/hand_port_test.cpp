#include "node/hand_port.h"

#include <gtest/gtest.h>

namespace tandem::node {
namespace {

/// Moves 3 mm a read; answers or not, knows its velocity or not.
class PlainDevice final : public devices::HapticDevice {
 public:
  PlainDevice(const bool& answers, bool knows_velocity)
      : answers_(answers), knows_velocity_(knows_velocity) {}
  [[nodiscard]] const devices::DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] devices::DeviceStatus read(std::int64_t slot,
                                           devices::DeviceSample& out) noexcept override {
    if (!answers_) return devices::DeviceStatus::kDisconnected;
    out.position = {0.003 * static_cast<double>(slot), 0.0, 0.0};
    out.velocity = {7.0, 0.0, 0.0};
    out.has_velocity = knows_velocity_;
    return devices::DeviceStatus::kOk;
  }
  [[nodiscard]] devices::DeviceStatus write(const devices::DeviceCommand&) noexcept override {
    return devices::DeviceStatus::kOk;
  }
  void stop() noexcept override {}

 private:
  const bool& answers_;
  bool knows_velocity_;
  devices::DeviceInfo info_;
};

HandPort<double> port_of(const bool& answers, bool knows_velocity) {
  core::Scene scene;
  scene.rates.local_hz = 1000.0;
  scene.users.resize(1);
  scene.users[0].fingers.resize(1);
  std::vector<std::unique_ptr<devices::HapticDevice>> devices;
  devices.push_back(std::make_unique<PlainDevice>(answers, knows_velocity));
  return HandPort<double>(scene, 0, std::move(devices));
}

TEST(HandPort, ADeviceWithoutVelocityGetsTheDifferenceOfItsPositions) {
  bool answers = true;
  auto port = port_of(answers, false);
  core::Fault faults = core::Fault::kNone;
  EXPECT_EQ(port.read(1, faults)[0].v, 0.0);  // of one sample there is no difference
  EXPECT_NEAR(port.read(2, faults)[0].v, 3.0, 1e-12);
  EXPECT_NEAR(port.read(3, faults)[0].v, 3.0, 1e-12);
  EXPECT_EQ(faults, core::Fault::kNone);
  // Silent for a while: at rest; then the mean velocity of the way moved meanwhile.
  answers = false;
  EXPECT_EQ(port.read(4, faults)[0].v, 0.0);
  EXPECT_NEAR(port.read(5, faults)[0].p, 0.009, 1e-15);
  EXPECT_TRUE(has(faults, core::Fault::kDeviceRead));
  answers = true;
  EXPECT_NEAR(port.read(50, faults)[0].v, 3.0, 1e-12);
  EXPECT_NEAR(port.read(51, faults)[0].v, 3.0, 1e-12);
}

TEST(HandPort, ADevicesOwnVelocityIsTaken) {
  const bool answers = true;
  auto port = port_of(answers, true);
  core::Fault faults = core::Fault::kNone;
  EXPECT_EQ(port.read(1, faults)[0].v, 7.0);
}

}  // namespace
}  // namespace tandem::node
