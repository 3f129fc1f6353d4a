#pragma once

#include <string>

#include "core/scene.h"
#include "node/stability_guard.h"

namespace tandem::cli {

/// Predicts a scene's stability for whom runs it: growth without delay, how much delay is borne,
/// and, asked later, which gain to lower. Planar scenes are judged at their grasp. A scene without
/// a prediction (space, walls that let go of nothing linear) says so.
[[nodiscard]] node::StabilityPrediction predict_stability(const core::Scene& scene);

/// Which gain to lower so that the scene is stable at a round trip of so many ticks and one more,
/// as options to give: the smallest change of one kind of coupler, else of all. For people.
[[nodiscard]] std::string advice(const core::Scene& scene, int ticks);

/// What guards a node. `refuses`: else it warns. Where `scene` is given it is predicted at once;
/// throws Failed if it is refused however short the delay.
[[nodiscard]] node::GuardMaker guard_maker(bool refuses, const core::Scene* scene);

}  // namespace tandem::cli
