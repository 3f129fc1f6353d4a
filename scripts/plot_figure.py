#!/usr/bin/python3
"""Draws what `tandem analyze figure`, stability and admittance found.  plot_figure.py RESULTS.json PICTURE.{png,svg,pdf}

Maps (chapter 5): the stable region and its exact boundary for each round trip. Frequency responses
(chapter 6): magnitude in decibels and phase, with the low frequencies of Fig 6.2 by themselves.
"""
import json
import math
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.collections import LineCollection  # noqa: E402

COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"]


def draw_map(results):
    figure, axis = plt.subplots(figsize=(6.4, 4.6))
    x, y = results["x"], results["y"]
    handles = []
    for i, region in enumerate(results["regions"]):
        color = COLORS[i % len(COLORS)]
        cells = [[int(c) for c in row] for row in region["cells"]]
        label = f"n = {region['round_trip_packets']:g}"
        if any(map(any, cells)):
            shade = matplotlib.colors.ListedColormap([(0, 0, 0, 0), color])
            axis.imshow(cells, origin="lower", aspect="auto", cmap=shade, vmin=0, vmax=1, alpha=0.16,
                        extent=(x["from"], x["to"], y["from"], y["to"]), interpolation="nearest")
        else:
            label += ": empty"
        lines = [[(s[0], s[1]), (s[2], s[3])] for s in region["boundary"]]
        axis.add_collection(LineCollection(lines, colors=color, linewidths=1.4))
        handles.append(plt.Line2D([], [], color=color, label=label))
    axis.set_xlim(x["from"], x["to"])
    axis.set_ylim(y["from"], y["to"])
    axis.set_xlabel(x["label"])
    axis.set_ylabel(y["label"])
    axis.set_title(results.get("title") or
                   f"Fig {results['figure']}: stable region (shaded) and its boundary")
    axis.legend(handles=handles, title="round trip [packets]", fontsize=8)
    axis.grid(alpha=0.3)
    return figure


def draw_response(results):
    # Fig 6.2 has its low frequencies in a picture of their own.
    omega = results["omega_rad_s"]
    ranges = [(omega[0], omega[-1])]
    if results.get("figure") == "6.2" and omega[0] < 10.0 < omega[-1]:
        ranges = [(omega[0], 10.0), (10.0, omega[-1])]
    figure, axes = plt.subplots(2, len(ranges), figsize=(5.4 * len(ranges) + 1, 6), squeeze=False,
                                sharex="col")
    for (low, high), (top, bottom) in zip(ranges, axes.T):
        inside = [i for i, w in enumerate(omega) if low <= w <= high]
        w = [omega[i] for i in inside]
        for n, curve in enumerate(results["curves"]):
            style = {"color": COLORS[n % len(COLORS)], "lw": 1.4,
                     "ls": "--" if n == 0 else "-"}
            size = [curve["magnitude"][i] for i in inside]
            phase = [curve["phase_deg"][i] for i in inside]
            top.semilogx(w, [20 * math.log10(m) if m else math.nan for m in size],
                         label=curve["name"], **style)
            # A turn more or less is the same phase: no jumps.
            for i in range(1, len(phase)):
                phase[i] -= 360 * round((phase[i] - phase[i - 1]) / 360)
            bottom.semilogx(w, phase, **style)
        bottom.set_xlabel("frequency [rad/s]")
        for axis in (top, bottom):
            axis.grid(alpha=0.3, which="both")
    kind, unit = results["response"].split(" ", 1)
    axes[0, 0].set_ylabel(f"|{kind}| [dB re 1 {unit.strip('[]')}]")
    axes[1, 0].set_ylabel("phase [degree]")
    axes[0, -1].legend(fontsize=8)
    figure.suptitle(results.get("title") or f"Fig {results['figure']}: admittance felt by a hand")
    return figure


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        results = json.load(file)
    figure = draw_map(results) if results["kind"] == "map" else draw_response(results)
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=100)


if __name__ == "__main__":
    main()
