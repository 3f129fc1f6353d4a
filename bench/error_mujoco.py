#!/usr/bin/env python3
"""MuJoCo on the cases of `tandem bench error`, from its Python wheel (pip install mujoco).

Reads one case as JSON from the first argument, prints one JSON line for each setting and rate. Whole
stretches run inside mj_step(nstep), so Python's own time is not counted; stick-slip, where the
coefficient is switched between steps, is timed on the same model without the switching.
"""

import json
import sys
import time

try:
    import mujoco
    import numpy as np
except ImportError:
    sys.exit("no mujoco: pip install mujoco")

INTEGRATORS = {
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
}

HEAD = """<mujoco><option gravity="0 0 {gravity}" cone="elliptic" iterations="100" tolerance="0">
<flag warmstart="enable" energy="disable" sensor="disable" actuation="disable"/></option><worldbody>
"""


def cart(name, mass, x=0.0, joint="", axes="x"):
    """A mass that only slides."""
    joints = "".join(
        f'<joint name="{name}{a}" type="slide" axis="{"1 0 0" if a == "x" else "0 1 0" if a == "y" else "0 0 1"}" {joint}/>'
        for a in axes
    )
    return (
        f'<body name="{name}" pos="{x} 0 0">{joints}'
        f'<inertial pos="0 0 0" mass="{mass}" diaginertia="1 1 1"/></body>'
    )


def tendon(a, b, c):
    return (
        f'<fixed stiffness="{c["stiffness"]}" damping="{c["damping"]}" springlength="0">'
        f'<joint joint="{a}x" coef="1"/><joint joint="{b}x" coef="-1"/></fixed>'
    )


def xml(c):
    which = c["case"]
    body = HEAD.format(gravity=-c["gravity"] if which == "slide" else 0.0)
    if which == "masses":
        body += cart("h", c["hand_mass"]) + cart("o", c["object_mass"])
        return body + "</worldbody><tendon>" + tendon("h", "o", c) + "</tendon></mujoco>"
    if which == "hands":
        body += cart("a", c["hand_mass"]) + cart("o", c["object_mass"]) + cart("b", c["hand_mass"])
        return (
            body + "</worldbody><tendon>" + tendon("a", "o", c) + tendon("b", "o", c)
            + "</tendon></mujoco>"
        )
    if which == "wall":
        # The limit of a joint is a wall. Negative solref: stiffness and damping by mass.
        k, b = c["stiffness"] / c["object_mass"], c["damping"] / c["object_mass"]
        limit = (
            f'limited="true" range="-10 {c["gap"]}" solreflimit="{-k} {-b}" '
            f'solimplimit="0.9999 0.9999 0.001"'
        )
        return body + cart("o", c["object_mass"], joint=limit) + "</worldbody></mujoco>"
    if which == "stick_slip":
        # Dry friction of a joint, and the spring whose end moves is the joint's own.
        friction = f'stiffness="{c["draw_spring"]}" frictionloss="{c["sticks"] * c["normal_force"]}"'
        friction += ' solimpfriction="0.9999 0.9999 0.001"'
        return body + cart("o", c["hand_mass"], joint=friction) + "</worldbody></mujoco>"
    if which == "slide":
        half = 0.5 * c["box_size"]
        return body + (
            f'<geom type="plane" size="1 1 1" friction="{c["slide_friction"]} 0 0" solref="-1e5 -600" '
            'solimp="0.9999 0.9999 0.001"/>'
            f'<body pos="0 0 {half}"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'
            f'<joint type="slide" axis="0 0 1"/><geom type="box" size="{half} {half} {half}" '
            f'mass="{c["object_mass"]}" friction="{c["slide_friction"]} 0 0" condim="3" '
            'solref="-1e5 -600" solimp="0.9999 0.9999 0.001"/></body></worldbody></mujoco>'
        )
    j = c["moments"]
    return body + (
        f'<body><freejoint/><inertial pos="0 0 0" mass="{c["object_mass"]}" '
        f'diaginertia="{j[0]} {j[1]} {j[2]}"/></body></worldbody></mujoco>'
    )


class Run:
    def __init__(self, c, model, hz):
        self.c, self.model, self.hz = c, model, hz
        model.opt.timestep = 1.0 / hz
        self.data = mujoco.MjData(model)
        which, v, f = c["case"], self.data.qvel, self.data.qfrc_applied
        if which == "masses":
            v[1] = c["thrown"]
        elif which == "hands":
            f[0], f[2] = c["pushed"]
        elif which == "wall":
            v[0] = c["flight"]
        elif which == "slide":
            v[0:2] = c["slide_speed"]
        elif which == "spin":
            v[3:6] = c["spin"]
        self.time = 0

    def steps(self, count):
        if self.c["case"] != "stick_slip":
            mujoco.mj_step(self.model, self.data, nstep=count)
            return
        c = self.c
        for _ in range(count):
            end = c["draw_speed"] * self.time / self.hz
            # The spring's pull to its moving end, beside the one to the origin.
            self.data.qfrc_applied[0] = c["draw_spring"] * end
            mu = c["slips"] if self.data.qvel[0] > 1e-4 else c["sticks"]
            self.model.dof_frictionloss[0] = mu * c["normal_force"]
            mujoco.mj_step(self.model, self.data)
            self.time += 1

    def sample(self):
        which, q, v = self.c["case"], self.data.qpos, self.data.qvel
        if which == "masses" or which == "hands":
            return [x for i in range(len(q)) for x in (q[i], v[i])]
        if which == "wall" or which == "stick_slip":
            return [q[0], v[0]]
        if which == "slide":
            return [q[0], q[1], v[0], v[1]]
        w = np.zeros(3)
        mujoco.mju_rotVecQuat(w, v[3:6].copy(), q[3:7].copy())
        return list(q[3:7]) + list(w)


def main():
    mujoco.set_mju_user_warning(lambda message: None)  # of what blows up; the samples show it
    c = json.loads(sys.argv[1])
    for name, integrator in INTEGRATORS.items():
        model = mujoco.MjModel.from_xml_string(xml(c))
        model.opt.integrator = integrator
        if c["case"] == "spin":
            model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        elif c["case"] in ("masses", "hands"):
            model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        for hz in c["rates"]:
            per, count = hz // c["grid"], int(c["seconds"] * c["grid"])
            run, samples = Run(c, model, hz), []
            for _ in range(count):
                run.steps(per)
                samples += run.sample()
            least = 1e300
            for _ in range(3):
                run = Run(c, model, hz)
                start = time.thread_time_ns()
                mujoco.mj_step(model, run.data, nstep=count * per)
                least = min(least, time.thread_time_ns() - start)
            line = {
                "setting": name,
                "hz": hz,
                "ns_per_s": least / c["seconds"],
                "samples": [float(x) if np.isfinite(x) else None for x in samples],
            }
            print(json.dumps(line))


main()
