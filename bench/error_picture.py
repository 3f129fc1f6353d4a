#!/usr/bin/env python3
"""Work-precision diagrams from the CSV of `tandem bench error`.  error_picture.py RUNS.csv PICTURE

One panel for each case and stiffness: error over the processor time of a simulated second. Down and
left is better. Tandem's schemes are drawn thick, the default with dots; of each peer its settings.
"""
import csv
import math
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

COLOURS = {"box2d": "tab:green", "bullet": "tab:purple", "ode": "tab:brown", "mujoco": "tab:gray"}
SCHEMES = {"zero_order_hold": "tab:blue", "semi_implicit_euler": "tab:cyan",
           "explicit_euler": "gold", "exact_coupler": "tab:red", "contact_law": "tab:blue"}


def main():
    with open(sys.argv[1], newline="") as file:
        rows = list(csv.DictReader(file))
    panels = {}
    for row in rows:
        if row["in_tandem"] == "0":
            continue
        panel = panels.setdefault((row["case"], float(row["stiffness_n_per_m"])), {})
        panel.setdefault((row["engine"], row["setting"], row["default"] == "1"), []).append(row)
    columns = min(5, len(panels))
    lines = math.ceil(len(panels) / columns)
    figure, axes = plt.subplots(lines, columns, figsize=(3.6 * columns, 3.1 * lines), squeeze=False)
    for axis in axes.flat[len(panels):]:
        axis.axis("off")
    legend = {}
    for axis, ((case, stiffness), curves) in zip(axes.flat, panels.items()):
        for (engine, setting, default), curve in curves.items():
            points = [(float(r["ns_per_simulated_s"]) * 1e-6, float(r["error"])) for r in curve]
            points = [(t, max(e, 1e-17)) for t, e in points if math.isfinite(e)]
            if not points:
                continue
            own = engine == "tandem"
            colour = SCHEMES.get(setting, "k") if own else COLOURS.get(engine, "k")
            (line,) = axis.plot(*zip(*points), color=colour, lw=2 if own else 0.8,
                                marker="o" if default else None, ms=4, alpha=1 if own else 0.8)
            legend.setdefault(f"Tandem, {setting}" if own else engine, line)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_title(f"{case}, {stiffness:.0f} N/m" if stiffness else case, fontsize=9)
        axis.set_xlabel("ms of processor per simulated second", fontsize=7)
        axis.set_ylabel("error [rad]" if case == "spin" else "error [m]", fontsize=7)
        axis.tick_params(labelsize=7)
        axis.grid(alpha=0.3)
    figure.legend(legend.values(), legend.keys(), loc="lower center", ncol=5, fontsize=8)
    figure.suptitle(f"Work against error, 256 to 16384 steps a second ({rows[0]['machine']})",
                    fontsize=10)
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    figure.savefig(sys.argv[2], dpi=110)


if __name__ == "__main__":
    main()
