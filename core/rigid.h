#pragma once

#include <glm/gtc/quaternion.hpp>

#include "core/vec.h"

namespace tandem::core {

/// Where frame B is in frame A: p_A = t + q p_B.
struct Rigid {
  Vec3 t{0.0};
  Quat q{1.0, 0.0, 0.0, 0.0};

  [[nodiscard]] Vec3 operator()(const Vec3& p) const noexcept { return t + q * p; }
  [[nodiscard]] Rigid operator*(const Rigid& b) const noexcept { return {t + q * b.t, q * b.q}; }
  [[nodiscard]] Rigid inverse() const noexcept {
    const Quat back = glm::conjugate(q);
    return {back * -t, back};
  }
};

}  // namespace tandem::core
