#!/usr/bin/env python3
"""docs/cost.md from what the benches print, so that no number in it was typed.

  bench/cost_page.py measure TANDEM_PROGRAM [NAME ...] [-- options of `bench error`]
                            runs the commands (or only those named) and keeps what they printed in
                            docs/cost.json; on a quiet machine, minutes. `scale` and `latency` run
                            only if named
  bench/cost_page.py write  writes docs/cost.md from docs/cost.json
  bench/cost_page.py check  says whether docs/cost.md is what `write` would write
"""
import datetime
import json
import os
import subprocess
import sys

DOCS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "docs")
STORE, PAGE, PICTURE = (os.path.join(DOCS, n) for n in ("cost.json", "cost.md", "error.png"))

COMMANDS = {
    "error": ["bench", "error"],
    "cost": ["bench", "cost"],
    "tick": ["bench", "tick"],
    "box_distributed": ["simulate", "--scene", "box_distributed", "--seconds", "60"],
    "axis_distributed": ["simulate", "--scene", "axis_distributed", "--seconds", "60"],
    "scale": ["bench", "scale"],
    "latency": ["bench", "latency"],
}
OPTIONAL = ("scale", "latency")  # the page is written without them, too

CASES = {
    "masses": "hand and object on one coupler, the object thrown",
    "hands": "two hands push and carry an object",
    "wall": "an object bounces off a spring-damper wall",
    "stick_slip": "Rabinowicz: drawn by a spring over a rough floor",
    "slide": "a box slides to rest under Coulomb friction",
    "spin": "a free body with three different moments",
}


def spoken(name):
    return "`tandem " + " ".join(COMMANDS[name]) + " --json -`"


def measure(program, names, extra):
    stored = {}
    if os.path.exists(STORE):
        with open(STORE) as file:
            stored = json.load(file)
    version = subprocess.run([program, "--version"], check=True, stdout=subprocess.PIPE, text=True).stdout
    for name in names or [n for n in COMMANDS if n not in OPTIONAL]:
        words = COMMANDS[name] + ["--json", "-"]
        if name == "error":
            words += ["--picture", PICTURE] + extra
        print("--", program, *words, file=sys.stderr)
        out = subprocess.run([program, *words], check=True, stdout=subprocess.PIPE, text=True).stdout
        printed = json.loads(out)
        if "runs" in printed:  # the peers' are in the verdict as far as they count
            printed["runs"] = [r for r in printed["runs"]
                               if r["engine"] == "tandem" and r["hz"] in (256, 1024, 16384)]
        stored[name] = {"command": spoken(name)[1:-1], "program": version.strip(),
                        "day": str(datetime.date.today()), "load": round(os.getloadavg()[0], 1),
                        "printed": printed}
        with open(STORE, "w") as file:
            json.dump(stored, file, indent=0)
            file.write("\n")


def case_name(row):
    stiff = row["stiffness"]
    return f'{row["case"]} {stiff:.0f}' if stiff else row["case"]


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def verdict(e, prefix):
    rows = []
    for c in e[prefix + "cases"]:
        against = c.get("against")
        there = "-"
        if against:
            there = (f'{against["peer"]} ({against["peer_setting"]}) at {against["peer_hz"]} Hz, '
                     f'{against["error"]:.1e}; {against["tandem_setting"]} at {against["tandem_hz"]} Hz')
        speed = c.get("least_speedup_at_equal_error")
        rows.append([case_name(c), f'{c["scale"]:.1e}', f'{c["least_error"]:.1e}',
                     f'{c["reached"]} of {c["points_of_the_peers_front"]}',
                     "-" if speed is None else f"{speed:.1f}", there])
    return table(["case", "way", "least error", "points of the peers' front kept", "least speed-up",
                  "there"], rows)


def where_not(e, prefix):
    slower, only = {}, {}
    for c in e[prefix + "where_not"]:
        (slower if "speedup" in c else only).setdefault(case_name(c), []).append(c)
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


def stick_slip(e):
    """The error of that case is the spring's, which the scene declares."""
    least = {c["stiffness"]: c["least_error"] for c in e["cases"] if c["case"] == "stick_slip"}
    if len(least) < 2:
        return ""
    told = ", ".join(f"{error:.1e} m at {stiff:.0f} N/m" for stiff, error in sorted(least.items()))
    return f": what is left of the error at the shortest steps is its give, {told}; the scene declares it"


def better(e):
    """Where another scheme than the default wins, in a sentence."""
    key, words = "least_speedup_at_equal_error", []
    for default, best in zip(e["cases"], e["best_scheme_cases"]):
        before, now = default.get(key), best.get(key)
        if before is None or now is None or before >= 5.0:
            continue
        words.append(f'{case_name(default)} {before:.1f} with the default, {now:.1f} at best '
                     f'({best["against"]["tandem_setting"]} at the point that decides)')
    return "Where the default falls short of 5: " + "; ".join(words) + "." if words else ""


def schemes(e):
    runs = {}
    for r in e["runs"]:
        if r["engine"] == "tandem":
            runs.setdefault((case_name(r), r["setting"], r["default"]), {})[r["hz"]] = r
    error = lambda r: "grows" if r["error"] is None else f'{r["error"]:.1e}'
    rows = []
    for (case, scheme, default), rates in runs.items():
        at = rates[1024]
        rows.append([case, scheme + (" (default)" if default else ""), error(rates[256]), error(at),
                     error(rates[16384]),
                     "-" if at["energy_drift"] is None else f'{at["energy_drift"]:.1e}',
                     f'{at["ns_per_simulated_s"] / 1024:.0f}'])
    return table(["case", "scheme", "256 Hz", "1024 Hz", "16384 Hz", "energy, 1024 Hz", "ns a tick"],
                 rows)


def features(cost):
    rows = []
    for r in cost["rows"]:
        if r["added_to"] is None:
            rows.append([f'**{r["feature"]}**', f'{r["tick_ns"]:.0f}', "", ""])
        else:
            rows.append([r["feature"], f'{r["tick_ns"]:.0f}',
                         f'{r["added_ns"]:+.0f} +- {r["spread_ns"]:.0f}', r["added_to"]])
    return table(["declared", "tick of the whole session [ns]", "added [ns]", "to"], rows)


def undeclared(cost):
    if "undeclared" not in cost:
        return "no other code runs for it, but that was not measured in this run."
    number = lambda r, key, form: "-" if r["instructions"] == 0 else format(r[key], form)
    rows = [[r["space"], r["lacks"].replace("_", " "), f'{r["tick_ns"]:.1f}',
             f'{r["cost_ns"]:+.1f} +- {r["spread_ns"]:.1f}', number(r, "instructions", ".1f"),
             number(r, "cost_instructions", "+.1f"), "yes" if r["same_bits"] else "NO"]
            for r in cost["undeclared"]]
    head = ["scene", "law without", "its tick [ns]", "costs the shipped law [ns]",
            "its instructions a tick", "costs the shipped law", "same bits"]
    verdict = "So it is" if cost["undeclared_costs_nothing"] else "It is not so"
    most, noise = cost["undeclared_most_instructions"], cost["undeclared_noise_ns"]
    return f"""what that costs is measured: a replica of
two users on a box that declares none of these, its law as shipped and compiled without the feature, in
turns. `shipped` is the law itself, `again` the same compiled once more, which differs by where the code
lies (with its scatter {noise["axis"]:.1f} and {noise["plane"]:.1f} ns); instructions are counted one by one (a packet period
and another, in the grasp).

{table(head, rows)}

No feature that is not declared takes more time than that and a hundredth of the tick: {verdict}. It is
asked for, though, and that is {most["costs"]:.0f} of {most["of"]:.0f} instructions at most ({most["by"]})."""


def growth(scale):
    number = lambda x: "-" if x is None else f"{x:.3g}"
    return table(["architecture", "what", "grows with", "exponent", "budget", "knee"],
                 [[g["architecture"], g["what"], g["over"], number(g["exponent"]), str(g["budget_of"]),
                   number(g["knee"])] for g in scale["growth"]])


def path(rate):
    rows = [[s["stage"], s["whose"]] + [f'{s[k]:.1f}' for k in ("p50_us", "p99_us")]
            for s in rate["stages"]]
    rows += [[c["name"], c["how"]] + ([f'{c[k]:.1f}' for k in ("p50_us", "p99_us")] if "p50_us" in c
                                      else ["-", str(c.get("why_not", ""))])
             for c in rate["carriers"]]
    return table(["part of the path, or carrier beside it", "whose, how", "median [us]", "p99 [us]"], rows)


def more(stored):
    """Sections of the benches that are there."""
    text = ""
    if "scale" in stored:
        text += f"""
## Users and objects

{spoken("scale")}

{growth(stored["scale"]["printed"])}
"""
    for rate in stored["latency"]["printed"]["rates"] if "latency" in stored else []:
        text += f"""
## From motion to force, {rate["packet_hz"]:.0f} packets a second of {rate["bytes"]:.0f} bytes

{spoken("latency")}

{path(rate)}
"""
    return text


def page(stored):
    e, cost, tick = (stored[n]["printed"] for n in ("error", "cost", "tick"))
    plane, axis = (stored[n]["printed"]["speedup"] for n in ("box_distributed", "axis_distributed"))
    peers = ", ".join(f"{p} ({state})" for p, state in e["peers"].items())
    ours, best = e["least_speedup_at_equal_error"], e["best_scheme_least_speedup_at_equal_error"]
    told = lambda speed, case: f"{speed:.1f}, in {case}" if speed else "none"
    when = "\n".join(f'- {spoken(n)}: {stored[n]["program"]}, {stored[n]["day"]}, load average of the '
                     f'minute that it ended {stored[n]["load"]}' for n in COMMANDS if n in stored)
    return f"""# What it costs and how right it is

Every number here was printed by one of these commands, is kept in [cost.json](cost.json), and was
put here by `bench/cost_page.py`:

{when}

Machine: {e["machine"]}. Peers in `bench error`: {peers}; {e["rounds"]} rounds, medians. Times are of
one machine: compare ratios, not nanoseconds.

## Time against error

{spoken("error")}

![Work against error](error.png)

Each case runs at 256 to 16384 steps a second. **Error** is the largest distance from the true course
at 256 points a second, in metres (`spin`: radians). True is a matrix exponential, a closed form, or
extended precision with events found to the last bit; [bench/README.md](../bench/README.md) says which.
**Time** is processor time of the thread for a simulated second, the least of several runs, then the
median over the rounds. Tandem runs whole: laws, simulated hands, the loop. Of each peer the settings
that suit it best are tried, and its points that no other peer beats in both make the front to compare
with, as far as they are nearer than a twentieth of the way.

{chr(10).join(f"- `{k}`: {v}" for k, v in CASES.items())}

The number behind a case is the stiffness of its coupler or wall [N/m] (`stick_slip`: of Tandem's
tangential spring, which the true course does not have{stick_slip(e)}).

### The default scheme

Least speed-up at equal error over all: {told(ours, e["case"])}.

{verdict(e, "")}

Where it is not at least 5 times faster, or does not get there at all:

{where_not(e, "")}

### The best scheme of Tandem for the case

Least speed-up at equal error over all: {told(best, e["best_scheme_case"])}. {better(e)}

{verdict(e, "best_scheme_")}

Where not:

{where_not(e, "best_scheme_")}

### Every scheme

`bare_...` rows are a mass and a wall without law, hand and loop: what locating the moment of contact
by bisection within the tick would buy, beside the same force held from the start of the tick.

{schemes(e)}

## What each thing in a scene costs

{spoken("cost")}: one tick of the whole session (users, hands, modelled links), processor time, medians;
+- is half the middle half of the rounds.

{features(cost)}

Two masses and a coupler in plain doubles take {cost["plain_axis_ns"]:.1f} ns; the axis scene takes
{cost["axis_over_plain"]:.1f} times that, for hand, packets' slots, faults and outputs. What a scene does
not declare is not in its row: {undeclared(cost)}

## A tick, and virtual time

- {spoken("tick")}: one planar tick with {tick["fingers"]} fingers, {tick["walls"]} walls, friction and
  another copy {tick["tick_ns"]:.0f} ns; the same work in plain doubles {tick["plain_tick_ns"]:.0f} ns;
  ratio {tick["ratio"]:.2f} (at most 2).
- {spoken("box_distributed")}: {plane:.0f} times real time on one core (at least 1000).
- {spoken("axis_distributed")}: {axis:.0f} times (at least 3000).
{more(stored)}
## What the numbers cannot tell

- The hand here is a model with known mass. A person's is not: the error of a scheme on `masses` and
  `hands` is that of coupling a *sampled* hand, and no engine escapes it with a real device. That an
  engine of higher order does here is because the hand is a body inside its simulation.
- `zero_order_hold` is the exact answer of the sampled network (`error_of_law` in the CSV, rounding);
  its distance from the continuous course is what sampling costs, not what the integrator adds.
- One or two bodies say nothing about piles, joints, meshes: that is what the peers are made for.
- Box2D is single precision and has rigid contacts, so a soft wall is outside its model; it is
  given the true rebound. Peers have one friction coefficient; in `stick_slip` theirs is switched
  between static and dynamic from outside.
"""


def main():
    words = sys.argv[1:]
    extra = []
    if "--" in words:
        extra = words[words.index("--") + 1:]
        words = words[:words.index("--")]
    if len(words) > 1 and words[0] == "measure":
        unknown = [n for n in words[2:] if n not in COMMANDS]
        if unknown:
            sys.exit(f"cost_page.py: no such name: {', '.join(unknown)}; there are {', '.join(COMMANDS)}")
        measure(words[1], words[2:], extra)
        return
    if words not in (["write"], ["check"]):
        sys.exit(__doc__)
    with open(STORE) as file:
        stored = json.load(file)
    missing = [n for n in COMMANDS if n not in stored and n not in OPTIONAL]
    if missing:
        sys.exit(f"cost_page.py: docs/cost.json lacks {', '.join(missing)}: run `measure` first")
    text = page(stored)
    if words == ["write"]:
        with open(PAGE, "w") as file:
            file.write(text)
        return
    with open(PAGE) as file:
        if file.read() != text:
            sys.exit("cost_page.py: docs/cost.md is not what docs/cost.json says; run `cost_page.py write`")


main()
