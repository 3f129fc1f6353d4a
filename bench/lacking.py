#!/usr/bin/env python3
"""The sources of a law that really lacks a feature, for `tandem bench cost`.

  bench/lacking.py FEATURE FOLDER   writes into FOLDER the headers of core/ that have the feature,
                                    without it; `shipped` and `again`: nothing is changed

An edit that no longer fits the sources is an error: then it has to be written anew here.
"""
import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

FEATURES = {
    "shipped": [],
    "again": [],  # the same once more: what two compilations of one source differ by
    "walls": [(f"core/{world}_world.h",
               "bool has_walls() const noexcept { return wall_count_ > 0; }",
               "static constexpr bool has_walls() noexcept { return false; }")
              for world in ("axis", "plane")],
    "device": [
        ("core/finger_output.h", "if (estimated_[f]) out[f].v = estimates_[f].update(raw[f].p);", ""),
        ("core/finger_output.h", """    for (int f = 0; f < fingers; ++f)
      if (guarded_[f]) output.forces[f] = guards_[f].pass(output.forces[f], output.faults);
""", "")],
    "computation_delay": [
        ("core/finger_output.h", "return active_ ? wrenches_[object].push(wrench) : wrench;", "return wrench;"),
        ("core/finger_output.h", """    if (!active_) return;
    for (int f = 0; f < fingers; ++f) output.forces[f] = forces_[f].push(output.forces[f]);
""", "")],
    "silence": [
        ("core/presence.h", "if (!declared_) return false;", "return false;"),
        ("core/presence.h", "return ramp_ * ramp_ * (3.0 - 2.0 * ramp_);", "return 1.0;"),
        ("core/presence.h", "return joining_ ? 1.0 - gain() : 0.0;", "return 0.0;"),
        ("core/presence.h", "return stale_;", "return false;"),
        ("core/presence.h", "return declared_ && ramp_ <= 0.0;", "return false;")],
    "extrapolation": [
        ("core/reconstruction.h", "if (p.kind == ReconstructionKind::kHold || !(age > 0.0)) return {};",
         "return {};")],
    "compensation": [
        ("core/plane_body.h", "(wrench.force + now.v * p.compensation)", "wrench.force"),
        ("core/plane_body.h", "(wrench.torque + now.omega * p.compensation_rotation)", "wrench.torque"),
        ("core/axis_world.h", "if (object.compensation != 0.0) force += object.compensation * body.v;", "")],
    "ground_friction": [
        ("core/integrate.h", "const bool stopped = limit > 0.0 && rub_on_ground(limit, v);",
         "const bool stopped = false;")],
    "finger_friction": [
        ("core/contact_law.h", "if (gains.friction.static_coefficient <= 0.0) {", "if (true) {")],
    "moment_cancellation": [
        ("core/contact_law.h", "memory.pulses_left = braking_pulses(gains, -at.normal_velocity, T);", ""),
        ("core/contact_law.h", "memory.pulses_left > 0 ? ContactState::kMomentCancellation : ContactState::kPreSlide;",
         "ContactState::kPreSlide;"),
        ("core/contact_law.h", "if (memory.state == ContactState::kMomentCancellation) {", "if (false) {")],
}
FEATURES["all"] = [edit for name in FEATURES for edit in FEATURES[name]]


def main():
    if len(sys.argv) != 3 or sys.argv[1] not in FEATURES:
        sys.exit(__doc__)
    os.makedirs(sys.argv[2], exist_ok=True)
    texts = {}
    for file, old, new in FEATURES[sys.argv[1]]:
        if file not in texts:
            with open(os.path.join(ROOT, file)) as source:
                texts[file] = source.read()
        if texts[file].count(old) != 1:
            sys.exit(f"bench/lacking.py: {sys.argv[1]}: not once in {file}: {old!r}; write the edit anew")
        texts[file] = texts[file].replace(old, new)
    for file, text in texts.items():
        path = os.path.join(sys.argv[2], file)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w") as out:
            out.write(text)
    with open(os.path.join(sys.argv[2], "stamp"), "w") as out:
        out.write(sys.argv[1] + "\n")


main()
