#!/usr/bin/python3
"""Draws force and path of the sessions of `tandem demo`.  plot_demo.py PICTURE DATA.csv ...

One column of axes a session: path along the carry, force of the hands, gap of the copies.
"""
import csv
import os
import sys

try:
    import matplotlib
except ImportError:
    sys.exit(3)

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def read(name):
    with open(name, newline="") as file:
        rows = list(csv.reader(file))
    return {c: [float(r[i]) for r in rows[1:]] for i, c in enumerate(rows[0])}


def main():
    picture, files = sys.argv[1], sys.argv[2:]
    figure, axes = plt.subplots(3, len(files), figsize=(6.5 * len(files), 8), squeeze=False,
                                sharex="col", sharey="row")
    for (top, middle, bottom), name in zip(axes.T, files):
        table = read(name)
        t = table["t_s"]
        top.set_title(os.path.splitext(os.path.basename(name))[0])
        top.plot(t, table["commanded_m"], "k--", lw=1, label="hands' target")
        # The box is carried along the axis on which it moves most.
        boxes = [c for c in table if c[-4:] in ("_x_m", "_y_m", "_z_m")]
        carry = max(boxes, key=lambda c: max(table[c]) - min(table[c]))[-4:]
        for column in boxes:
            if column.endswith(carry):
                owner = column[:-4].replace("user", "user ")
                top.plot(t, table[column], lw=1, label=f"box at {owner}")
        middle.plot(t, table["net_force_N"], lw=0.8,
                    label="all hands on the box, less ground friction")
        middle.plot(t, table["inertial_force_N"], "k--", lw=0.8,
                    label="ideal: mass times acceleration")
        middle.set_ylim(-8, 8)
        bottom.plot(t, [1e3 * g for g in table["gap_m"]], lw=1)
        if len(boxes) == 3:
            bottom.text(0.5, 0.9, "one box, at the server", ha="center",
                        transform=bottom.transAxes, fontsize=8)
        bottom.set_xlabel("t [s]")
        for axis in (top, middle):
            axis.legend(fontsize=7, loc="upper right")
        for axis in (top, middle, bottom):
            axis.grid(alpha=0.3)
    axes[0, 0].set_ylabel("path along the carry [m]")
    axes[1, 0].set_ylabel("force along the carry [N]")
    axes[2, 0].set_ylabel("distance between the copies [mm]")
    figure.tight_layout()
    figure.savefig(picture, dpi=120)


if __name__ == "__main__":
    main()
