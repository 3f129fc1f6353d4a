#pragma once

#include <cstdint>

#include "core/scene.h"

namespace tandem::scene {

/// FNV-1a, 64 bit, over a byte form of everything that the peers of a session must agree on: space,
/// architecture, rates, integrator, reconstruction, silence, contact, gravity, objects, walls,
/// couplers, users and their fingers' names, initial positions and radii, each in the order of
/// scene_fields.h (little-endian doubles with -0 as 0, strings and lists with their length). Not in
/// it: the scene's name and description, devices, and what a simulated hand does. It depends on
/// values only: not on formatting, comments, defaults written out, machine or library.
[[nodiscard]] std::uint64_t shared_hash(const core::Scene& scene);

}  // namespace tandem::scene
