#include "view/pointer_control.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::view {
namespace {

constexpr double kSpeed = 0.4;      ///< of the hand's middle at most [m/s]
constexpr double kPinchTime = 0.4;  ///< from open to closed [s]
constexpr double kClosed = 0.35;    ///< of the way from the middle to the open finger
constexpr double kKeySpeed = 0.03;  ///< of the second finger [m/s]

}  // namespace

PointerControl::PointerControl(const Layout& layout, int user) : layout_(layout), user_(user) {
  const auto& fingers = layout.scene.users[static_cast<std::size_t>(user)].fingers;
  for (const core::FingerParameters& f : fingers)
    middle_ += f.position / static_cast<double>(fingers.size());
  for (const core::FingerParameters& f : fingers) home_.push_back(f.position - middle_);
}

bool PointerControl::on_plane(const Vec2& pixel, const Picture& picture, Vec3& out) const {
  const Vec3 eye = picture.eye(), ray = picture.ray(pixel);
  const bool space = layout_.scene.space == core::Space::kSpace;
  const Vec3 through = layout_.place(middle_, user_);
  Vec3 normal{0.0, 0.0, 1.0};
  if (space) normal = glm::normalize(Vec3{eye.x - through.x, eye.y - through.y, 1e-9});
  const double slope = glm::dot(ray, normal);
  if (std::abs(slope) < 1e-3) return false;
  const double way = glm::dot(through - eye, normal) / slope;
  if (way <= 0.0) return false;
  const Vec3 hit = eye + ray * way;
  out = middle_;
  out.x = hit.x;
  if (layout_.scene.space != core::Space::kAxis) out.y = hit.y;
  if (space) out.z = hit.z;
  return true;
}

devices::PointerTargets PointerControl::update(const Input& input, const Picture& picture) {
  Vec3 wanted = middle_;
  if (input.inside && on_plane(input.pixel, picture, wanted)) {
    // Not beyond what is in sight: a ray near the horizon goes far.
    const Vec3 centre = 0.5 * (layout_.low + layout_.high);
    const double reach = 1.5 * glm::length(layout_.high - layout_.low);
    for (int i = 0; i < 3; ++i)
      wanted[i] = std::clamp(wanted[i], centre[i] - reach, centre[i] + reach);
    const Vec3 way = wanted - middle_;
    const double length = glm::length(way), most = kSpeed * input.seconds;
    middle_ += length > most ? way * (most / length) : way;
  }
  const double step = (1.0 - kClosed) * input.seconds / kPinchTime;
  open_ = std::clamp(open_ + (input.pinch ? -step : step), kClosed, 1.0);
  second_ += Vec3{input.second_finger.x, input.second_finger.y, 0.0} * (kKeySpeed * input.seconds);
  if (glm::length(second_) > layout_.unit) second_ *= layout_.unit / glm::length(second_);

  devices::PointerTargets targets;
  const bool pinches = home_.size() > 1;
  for (std::size_t f = 0; f < home_.size(); ++f)
    targets.fingers[f] =
        middle_ + home_[f] * (pinches ? open_ : 1.0) + (f == 1 ? second_ : Vec3{0.0});
  return targets;
}

}  // namespace tandem::view
