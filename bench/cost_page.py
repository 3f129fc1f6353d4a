#!/usr/bin/env python3
"""Writes docs/cost.md from what the benches print, so that no number in it was typed.

  bench/cost_page.py TANDEM_PROGRAM [FOLDER] [-- options of `bench error`]

Runs `bench error` and `bench tick` (minutes) and writes FOLDER/cost.md and FOLDER/error.png; FOLDER
is docs by default.
"""
import datetime
import json
import os
import subprocess
import sys

CASES = {
    "masses": "hand and object on one coupler, the object thrown",
    "hands": "two hands push and carry an object",
    "wall": "an object bounces off a spring-damper wall",
    "stick_slip": "Rabinowicz: drawn by a spring over a rough floor",
    "slide": "a box slides to rest under Coulomb friction",
    "spin": "a free body with three different moments",
}


def run(program, *words):
    print("--", program, *words, file=sys.stderr)
    out = subprocess.run([program, *words], check=True, stdout=subprocess.PIPE, text=True).stdout
    return json.loads(out)


def name(row):
    stiff = row["stiffness"]
    return f'{row["case"]} {stiff:.0f}' if stiff else row["case"]


def verdict(e, prefix):
    lines = ["| case | way | least error | points of the peers' front kept | least speed-up | there |",
             "|---|---|---|---|---|---|"]
    for c in e[prefix + "cases"]:
        against = c.get("against")
        there = "-"
        if against:
            there = (f'{against["peer"]} ({against["peer_setting"]}) at {against["peer_hz"]} Hz, '
                     f'{against["error"]:.1e}; {against["tandem_setting"]} at {against["tandem_hz"]} Hz')
        speed = c.get("least_speedup_at_equal_error")
        lines.append(f'| {name(c)} | {c["scale"]:.1e} | {c["least_error"]:.1e} | {c["reached"]} of '
                     f'{c["points_of_the_peers_front"]} | {"-" if speed is None else f"{speed:.1f}"} '
                     f'| {there} |')
    return "\n".join(lines)


def where_not(e, prefix):
    slower, only = {}, {}
    for c in e[prefix + "where_not"]:
        (slower if "speedup" in c else only).setdefault(name(c), []).append(c)
    lines = []
    for case, rows in slower.items():
        worst = min(rows, key=lambda r: r["speedup"])
        lines.append(f'- {case}: {len(rows)} points below 5 times; the least, {worst["speedup"]:.1f}, '
                     f'against {worst["peer"]} ({worst["peer_setting"]}) at {worst["error"]:.1e}.')
    for case, rows in only.items():
        peers = sorted({r["peer"] for r in rows})
        lines.append(f'- {case}: errors from {max(r["error"] for r in rows):.1e} down to '
                     f'{min(r["error"] for r in rows):.1e} are kept by {", ".join(peers)} only.')
    return "\n".join(lines) if lines else "Nowhere."


def schemes(e):
    lines = ["| case | scheme | 256 Hz | 1024 Hz | 16384 Hz | energy, 1024 Hz | ns a tick |",
             "|---|---|---|---|---|---|---|"]
    table = {}
    for r in e["runs"]:
        if r["engine"] == "tandem":
            table.setdefault((name(r), r["setting"], r["default"]), {})[r["hz"]] = r
    error = lambda r: "grows" if r["error"] is None else f'{r["error"]:.1e}'
    for (case, scheme, default), rates in table.items():
        at = rates[1024]
        drift = "-" if at["energy_drift"] is None else f'{at["energy_drift"]:.1e}'
        lines.append(f'| {case} | {scheme}{" (default)" if default else ""} | {error(rates[256])} | '
                     f'{error(at)} | {error(rates[16384])} | {drift} | '
                     f'{at["ns_per_simulated_s"] / 1024:.0f} |')
    return "\n".join(lines)


def main():
    words = sys.argv[1:]
    extra = []
    if "--" in words:
        extra = words[words.index("--") + 1:]
        words = words[:words.index("--")]
    if not words:
        sys.exit(__doc__)
    program, folder = words[0], words[1] if len(words) > 1 else "docs"
    picture = os.path.join(folder, "error.png")
    e = run(program, "bench", "error", "--json", "-", "--picture", picture, *extra)
    tick = run(program, "bench", "tick", "--json", "-")
    peers = ", ".join(f"{p} ({state})" for p, state in e["peers"].items())
    load = os.getloadavg()[2]
    ours = e["least_speedup_at_equal_error"]
    best = e["best_scheme_least_speedup_at_equal_error"]
    text = f"""# What it costs and how right it is

Written by `bench/cost_page.py` from what `tandem bench error` and `tandem bench tick` printed on
{datetime.date.today()}: {e["machine"]}, {e["rounds"]} rounds, mean load {load:.1f} of the last
quarter of an hour (above 1: others were at work, and times are up to twice what a quiet machine
shows; ratios are interleaved). Peers: {peers}.

## Time against error

![Work against error](error.png)

Each case runs at 256 to 16384 steps a second. **Error** is the largest distance from the true course
at 256 points a second, in metres (`spin`: radians). True is a matrix exponential, a closed form, or
extended precision with events found to the last bit; `bench/README.md` says which. **Time** is
processor time of the thread for a simulated second, the least of several runs, then the median over
the rounds. Tandem runs whole: laws, simulated hands, the loop. Of each peer the settings that suit
it best are tried, and its points that no other peer beats in both make the front to compare with,
as far as they are nearer than a twentieth of the way.

{chr(10).join(f"- `{k}`: {v}" for k, v in CASES.items())}

The number behind a case is the stiffness of its coupler or wall [N/m] (`stick_slip`: of Tandem's
tangential spring, which the true course does not have).

### The default scheme

Least speed-up at equal error over all: {f"{ours:.1f}, in {e['case']}" if ours else "none"}.

{verdict(e, "")}

Where it is not at least 5 times faster, or does not get there at all:

{where_not(e, "")}

### The best scheme of Tandem for the case

Least speed-up at equal error over all: {f"{best:.1f}, in {e['best_scheme_case']}" if best else "none"}.

{verdict(e, "best_scheme_")}

Where not:

{where_not(e, "best_scheme_")}

### Every scheme

`bare_...` rows are a mass and a wall without law, hand and loop: what locating the moment of contact
within the tick would buy.

{schemes(e)}

## A tick

- one planar tick with {tick["fingers"]} fingers, {tick["walls"]} walls, friction and another copy:
  {tick["tick_ns"]:.0f} ns; the same work in plain doubles {tick["plain_tick_ns"]:.0f} ns; ratio
  {tick["ratio"]:.2f} (at most 2).
- virtual time on one core, two users with hands, laws and links: `box_distributed`
  {tick["virtual_speed_box_distributed"]:.0f} times real time (at least 1000), `axis_distributed`
  {tick["virtual_speed_axis_distributed"]:.0f} times (at least 3000).

## What the numbers cannot tell

- The hand here is a model with known mass. A person's is not: the error of a scheme on `masses` and
  `hands` is that of coupling a *sampled* hand, and no engine escapes it with a real device. That MuJoCo's
  RK4 does here is because the hand is a body inside its simulation.
- `zero_order_hold` is the exact answer of the sampled network (`error_of_law` in the CSV, rounding);
  its distance from the continuous course is what sampling costs, not what the integrator adds.
- One or two bodies say nothing about piles, joints, meshes: that is what the peers are made for.
- Box2D is single precision and has rigid contacts, so a soft wall is outside its model; it is
  given the true rebound. Peers have one friction coefficient; in `stick_slip` theirs is switched
  between static and dynamic from outside.
- Times are of one machine. Compare ratios, not nanoseconds.
"""
    with open(os.path.join(folder, "cost.md"), "w") as file:
        file.write(text)


main()
