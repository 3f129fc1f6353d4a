#!/usr/bin/python3
"""Draws a CSV table that `tandem` wrote.  plot_table.py KIND DATA.csv PICTURE.{png,svg,pdf}

KIND says which columns go on which axes; unknown kinds get one axis for every unit.
"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

TITLES = {
    "fig8.1_central": "Fig 8.1 centralized, Table 8.1",
    "fig8.1_distributed": "Fig 8.1 distributed, Table 8.2",
    "fig8.3": "Fig 8.3: net force on the user's own copy",
    "fig8.4": "Fig 8.4: finger travel against a stiff wall",
    "trajectory": "Trajectory",
}


def read(name):
    with open(name, newline="") as file:
        rows = list(csv.reader(file))
    return {c: [float(r[i]) for r in rows[1:]] for i, c in enumerate(rows[0])}


def main():
    kind, data, picture = sys.argv[1:4]
    table = read(data)
    t = table.pop("t_s")
    if kind.startswith("fig8.1"):
        groups = [("finger force x [N]", [c for c in table if c.endswith("fx_N")]), ("path", None)]
    elif kind == "fig8.3":
        groups = [("net force y [N]", list(table))]
    elif kind == "fig8.4":
        groups = [("push [N]", ["push_N"]),
                  ("finger travel [m]", [c for c in table if c != "push_N"])]
    else:
        groups = [("object [m, rad]", [c for c in table if "_object_" in c]),
                  ("finger [m]", [c for c in table if "_p" in c.split("finger")[-1][:3]]),
                  ("force [N]", [c for c in table if "_f" in c.split("finger")[-1][:3]
                                 and "_object_" not in c])]
    groups = [g for g in groups if g[1] is None or g[1]]
    figure, axes = plt.subplots(len(groups), 1, figsize=(8, 2.6 * len(groups)), squeeze=False)
    for axis, (label, columns) in zip(axes[:, 0], groups):
        if columns is None:
            axis.plot(table["box_x_m"], table["box_y_m"], lw=1)
            axis.set_xlabel("x [m]")
            axis.set_ylabel("y [m]")
            axis.set_aspect("equal", "datalim")
        else:
            for column in columns:
                axis.plot(t, table[column], lw=1, label=column)
            axis.set_xlabel("t [s]")
            axis.set_ylabel(label)
            if len(columns) <= 10:
                axis.legend(fontsize=7, loc="upper right")
        axis.grid(alpha=0.3)
    axes[0, 0].set_title(TITLES.get(kind, kind))
    figure.tight_layout()
    figure.savefig(picture, dpi=130)


if __name__ == "__main__":
    main()
