#pragma once

#define GLM_FORCE_XYZW_ONLY
#include <glm/gtc/quaternion.hpp>
#include <glm/mat2x2.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace tandem::core {

/// Vectors of doubles. Always write `Vec2 a{0.0}`: GLM leaves a vector uninitialised.
using Vec2 = glm::dvec2;
using Vec3 = glm::dvec3;
using Mat3 = glm::dmat3;
using Quat = glm::dquat;  ///< constructor order (w, x, y, z)

}  // namespace tandem::core
