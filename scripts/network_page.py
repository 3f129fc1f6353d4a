#!/usr/bin/python3
"""The section "What was found" of docs/network.md from what `tandem netem` wrote, so that no number
in it was typed.

  scripts/network_page.py run TANDEM_PROGRAM      runs the virtual sweeps (under a minute) and keeps
                                                  what the page needs in docs/network.json
  scripts/network_page.py take RESULTS.json ...   the same of results that are there already: what
                                                  `tandem netem --json` wrote of one sweep
  scripts/network_page.py write                   writes the section from docs/network.json
  scripts/network_page.py check                   says whether it is what `write` would write
`run` and `take` also draw docs/network.png (python3-matplotlib) and write the section.
"""
import json
import math
import os
import subprocess
import sys

DOCS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "docs")
STORE, PAGE, PICTURE = (os.path.join(DOCS, n) for n in ("network.json", "network.md", "network.png"))
BEGIN = ("<!-- from here: made by scripts/network_page.py from docs/network.json; changes by hand are "
         "lost -->\n")
END = "<!-- to here -->\n"

SWEEPS = ("thesis", "delay")
PLACES = {"virtual time": "virtual", "real sockets": "sockets"}
STYLES = {"hold": "hold", "compensated": "compensated", "extrapolate": "extrapolated"}
COLOURS = {"hold": ("#1f77b4", "o"), "compensated": ("#d95f02", "s"), "extrapolate": ("#2a9d4a", "^")}
TRIES = ("at_0.9_of_predicted", "at_1.1_of_predicted")


# ---- what is kept

def rounded(tree):
    """Six digits are more than any of it is good for."""
    if isinstance(tree, float):
        return float(f"{tree:.6g}")
    if isinstance(tree, dict):
        return {k: rounded(v) for k, v in tree.items()}
    if isinstance(tree, list):
        return [rounded(v) for v in tree]
    return tree


def picked(tree, *names):
    return {n: tree[n] for n in names if n in tree}


def mean(values):
    values = [v for v in values if isinstance(v, (int, float))]
    return sum(values) / len(values) if values else None


def kept_result(r):
    m = r["measured"]
    measured = picked(m, "largest_coupling_n_per_m", "drag_n_s_per_m")
    measured.update(picked(m["stability"], "judged", "stable"))
    measured["force_error_rms_weber"] = mean(s.get("force_error_rms_weber") for s in m["sites"])
    for name in TRIES:
        if name in m:
            measured[name] = picked(m[name], "judged", "stable",
                                    "coupling_over_that_of_its_own_delays")
    out = picked(r, "architecture", "style", "label", "mean_age_s", "coupling_name",
                 "missed_ticks_share")
    out["failed"] = "failed" in r
    out["predicted"] = picked(r["predicted"], "judged", "stable", "near_boundary", "drag_n_s_per_m",
                              "largest_coupling_n_per_m")
    out["measured"] = measured
    return out


def kept(data):
    out = picked(data, "sweep", "title", "knob", "on", "points", "failed", "near_boundary",
                 "disagreements", "approximate_disagreements", "disagreement_list",
                 "verdicts_compared", "left_out", "statement", "seed", "wall_s", "session_s",
                 "revision", "date", "machine", "granted", "delay_boundaries")
    out["contests"] = [dict(picked(c, "architecture", "coupling", "at"))
                       for c in data.get("contests", [])]
    out["results"] = [kept_result(r) for r in data["results"] if r["style"] in STYLES]
    return rounded(out)


def take(stored, data, where):
    if "results" not in data or data.get("on") not in PLACES:
        sys.exit(f"network_page.py: {where} is not the result of one sweep (tandem netem --json FILE)")
    if data["sweep"] not in SWEEPS:
        sys.exit(f"network_page.py: {where} is of sweep {data['sweep']}; the page has "
                 f"{', '.join(SWEEPS)}")
    stored.setdefault(PLACES[data["on"]], {})[data["sweep"]] = kept(data)


def spread(tree, depth):
    """JSON with a line for each item down to `depth`."""
    if depth == 0 or not isinstance(tree, (dict, list)) or not tree:
        return json.dumps(tree, ensure_ascii=False)
    items = (f"{json.dumps(k)}: {spread(v, depth - 1)}" for k, v in tree.items()) \
        if isinstance(tree, dict) else (spread(v, depth - 1) for v in tree)
    left, right = "{}" if isinstance(tree, dict) else "[]"
    return f"{left}\n" + ",\n".join(items) + f"\n{right}"


def keep(stored):
    _, made = page(stored)  # complete, before anything is written
    with open(STORE, "w", encoding="utf-8") as file:
        file.write(spread(stored, 4) + "\n")
    draw(stored)
    with open(PAGE, "w", encoding="utf-8") as file:
        file.write(made)


# ---- numbers for people

def number(x):
    if x is None:
        return math.nan
    return math.inf if x == "infinite" else float(x)


def cell(x, factor=1.0):
    x = number(x) * factor
    if math.isnan(x):
        return "–"
    if math.isinf(x):
        return "∞"
    if abs(x) < 5e-5:
        return "0"
    if abs(x) < 1000:
        return f"{x:.3g}"
    unit = 10 ** (math.floor(math.log10(abs(x))) - 2)
    return f"{unit * round(x / unit):.0f}"


def row(cells):
    return "| " + " | ".join(cells) + " |\n"


def table(heads, rows):
    return row(heads) + "|" + "---|" * len(heads) + "\n" + "".join(row(r) for r in rows)


def side(x):
    if not x or not x.get("judged"):
        return "–"
    return ("stable" if x["stable"] else "**not stable**") + (" ~" if x.get("near_boundary") else "")


def contest_table(data, contest):
    """Who has the least force error, who the largest coupling: the best in bold."""
    rows = []
    for at in contest["at"]:
        cells = [at["label"], cell(at["mean_age_s"], 1e3)]
        for best, key in (("least_force_error", "force_error_rms_weber"),
                          ("largest_coupling", "largest_coupling_n_per_m")):
            for style in STYLES:
                x = at.get("by", {}).get(style)
                if x is None:
                    text = "–"
                elif best == "least_force_error" and x["judged"] and not x["stable"]:
                    text = "not stable"
                else:
                    text = cell(x[key])
                    text = f"**{text}**" if style in at[best] else text
                cells.append(text + (" ~" if x and best == "least_force_error" and
                                     x["near_boundary"] else ""))
        rows.append(cells)
    names = list(STYLES.values())
    heads = ([data["knob"], "mean age [ms]", f"force error [Weber]: {names[0]}"] + names[1:] +
             [f"largest stable {contest['coupling']} [N/m]: {names[0]}"] + names[1:])
    return table(heads, rows)


def found(data):
    """Tables and sentences of one run, by architecture."""
    sentences = data["statement"]
    if not data["contests"]:
        return "".join(f"- {s}\n" for s in sentences)
    text = "".join(f"\n{s}\n" for s in sentences if s.startswith("In short"))
    for contest in data["contests"]:
        name = contest["architecture"]
        text += f"\n**{name}**\n\n" + contest_table(data, contest) + "\n"
        text += "".join(f"- {s[len(name) + 2:]}\n" for s in sentences if s.startswith(name + ". "))
    return text


def by_key(data):
    return {(r["architecture"], r["label"], r["style"]): r for r in data["results"]} if data else {}


def tried(r, name):
    t = r["measured"].get(name)
    if not t:
        return "–"
    ratio = number(t.get("coupling_over_that_of_its_own_delays"))
    return side(t) + ("" if math.isnan(ratio) else f" ({ratio:.2f})")


def side_by_side(virtual, sockets):
    """Predicted, virtual time and, if there was a run, sockets; None where a run lacks the point."""
    v, s = by_key(virtual), by_key(sockets)
    heads = ["", "age [ms]", "analysis", "virtual", "largest coupling [N/m]: analysis", "virtual",
             "drag [N s/m]: analysis", "virtual", "force error [Weber]: virtual"]
    if s:
        heads += ["sockets: age [ms]", "analysis of those delays", "sockets",
                  "largest coupling: analysis", "at 0.9 of it", "at 1.1 of it", "drag: analysis",
                  "sockets", "force error", "missed ticks [%]"]
    rows = []
    for key in list(v) + [k for k in s if k not in v]:
        cells = [f"{key[0]}, {key[1]}, {STYLES[key[2]]}"]
        for data in (v, s) if s else (v,):
            r = data.get(key)
            on_sockets = data is s
            if r is None or r["failed"]:
                cells += [["–", "did not run"][r is not None]] + ["–"] * (9 if on_sockets else 7)
                continue
            p, m = r["predicted"], r["measured"]
            cells += [cell(r["mean_age_s"], 1e3), side(p), side(m),
                      cell(p.get("largest_coupling_n_per_m"))]
            cells += [tried(r, n) for n in TRIES] if on_sockets else [
                cell(m["largest_coupling_n_per_m"])]
            cells += [cell(p.get("drag_n_s_per_m")), cell(m["drag_n_s_per_m"]),
                      cell(m["force_error_rms_weber"])]
            if on_sockets:
                cells.append(cell(r.get("missed_ticks_share"), 100))
        rows.append(cells)
    return table(heads, rows)


def boundaries(virtual, sockets):
    def ms(x):
        return "0: not stable with any" if number(x) == 0 else "up to 100" if number(x) == math.inf else cell(x, 1e3)
    real = {b["scene"]: b for b in sockets["delay_boundaries"]} if sockets else {}
    heads = ["scene", "analysis, linearised at the grasp", "virtual time"]
    heads += ["sockets: stable at", "sockets: not stable at"] if real else []
    rows = []
    for b in virtual["delay_boundaries"]:
        cells = [f"`{b['scene']}`", ms(b["predicted_s"]), ms(b["virtual_s"])]
        if real:
            r = real.get(b["scene"], {})
            cells += [cell(r.get("real_stable_s"), 1e3), cell(r.get("real_not_stable_s"), 1e3)]
        rows.append(cells)
    return table(heads, rows)


def runs(stored):
    rows = []
    for place, sweeps in stored.items():
        for data in sweeps.values():
            c = data.get("verdicts_compared", {})
            machine = data["machine"]
            compared = "all" if place == "virtual" else (
                f"{c.get('with_analysis', '–')} with the analysis, {c.get('with_virtual_time', '–')} "
                f"with virtual time; {c.get('near_boundary', '–')} too near, "
                f"{c.get('missed_ticks', '–')} missed ticks")
            rows.append([data["sweep"], data["on"], str(data["points"]), str(data["failed"]),
                         str(data["near_boundary"]), compared, f"**{data['disagreements']}**",
                         f"{data['wall_s']:.0f} s", data["revision"], data["date"],
                         f"{machine['processor']}, {machine['processors']} processors, "
                         f"{machine['kernel']}" +
                         (f"; {data['granted']}" if data.get("granted") else "")])
    return table(["sweep", "on", "points", "failed", "within 10 % of the boundary",
                  "verdicts compared", "disagreements", "took", "revision", "date", "machine"], rows)


def disagreements(data):
    wrong = [d for d in data["disagreement_list"] if d["exact"]]
    if not wrong:
        return ""
    return "\nDisagreements:\n\n" + "".join(f"- {d['point']}: {d['what']}\n" for d in wrong)


def section(stored):
    virtual, sockets = stored["virtual"], stored.get("sockets", {})
    real = sockets.get("thesis")
    text = BEGIN + (
        "No number from here on was typed: they are of the runs below, kept in `docs/network.json`. To "
        "run the virtual ones again:\n\n"
        "    scripts/network_page.py run build/release/bin/tandem\n\n"
        "and for the columns on sockets, on a quiet machine:\n\n"
        "    build/release/bin/tandem netem --sweep thesis --json real.json && "
        "scripts/network_page.py take real.json\n\n")
    if not real:
        text += ("**No run on sockets is kept yet**: what follows is of virtual time and analysis.\n\n")
    text += runs(stored)
    text += "\n![Largest stable coupling and drag over the mean age of samples](network.png)\n"
    text += ("\nLargest stable coupling and drag over the mean age of the samples, sweep `thesis`. "
             "Lines: analysis; hollow: virtual time" +
             ("; dashes: analysis of the delays measured on sockets; dots and crosses: stable and not "
              "on sockets, at 0.9 and 1.1 times the coupling predicted; filled: drag on sockets.\n" if real else ".\n"))
    text += "\n### Which reconstruction wins where\n\n"
    first = virtual["thesis"]["statement"][0] if virtual["thesis"]["contests"] else ""
    text += (f"What follows is printed by `tandem netem`. {first} ~: within 10 % of the boundary. "
             "Bold: best, or within 2 % of it.\n")
    for name in SWEEPS:
        text += f"\n#### `{name}` in virtual time: {virtual[name]['title']}\n"
        text += found(virtual[name]) + disagreements(virtual[name])
    for name, data in sockets.items():
        text += f"\n#### `{name}` on sockets\n\n"
        text += (data["statement"][0] + "\n" if data["contests"] else "")
        text += found(data) + disagreements(data)
        if data["left_out"]:
            text += "\nLeft out: " + "; ".join(data["left_out"]) + ".\n"
    text += ("\n### Predicted, virtual" + (", sockets" if real else "") + ": `thesis`\n\n" +
             ("At 0.9 and at 1.1 of the coupling that the analysis predicts from the delays measured on "
              "sockets; in brackets that coupling over the one predicted from the delays of the try "
              "itself.\n\n" if real else "") + side_by_side(virtual["thesis"], real))
    text += ("\n### Boundary in delay of the thesis' boxes\n\nShortest one-way delay, the same both "
             "ways, with which the grasp is no longer stable [ms].\n\n" +
             boundaries(virtual["thesis"], real))
    return text + END


# ---- picture

def draw(stored):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    virtual = stored["virtual"]["thesis"]["results"]
    sockets = stored.get("sockets", {}).get("thesis", {}).get("results", [])
    architectures = list(dict.fromkeys(r["architecture"] for r in virtual))
    figure, axes = plt.subplots(2, len(architectures), figsize=(4 * len(architectures), 6),
                                squeeze=False, layout="constrained", sharex=True)

    def curve(results, of, architecture, style):
        points = sorted((1e3 * number(r["mean_age_s"]), number(of(r))) for r in results
                        if not r["failed"] and (r["architecture"], r["style"]) == (architecture, style))
        shown = [p[1] if math.isfinite(p[1]) and (i == 1 or p[1] > 0) else math.nan for p in points]
        return [p[0] for p in points], shown

    rows = (("largest_coupling_n_per_m", "largest stable coupling [N/m]"),
            ("drag_n_s_per_m", "drag of one hand alone [N s/m]"))
    for i, (key, label) in enumerate(rows):
        predicted = lambda r: r["predicted"].get(key)  # noqa: E731
        measured = lambda r: r["measured"].get(key) if r["measured"]["stable"] or i == 0 else None  # noqa: E731
        for axis, architecture in zip(axes[i], architectures):
            for style, (colour, marker) in COLOURS.items():
                axis.plot(*curve(virtual, predicted, architecture, style), "-", color=colour, lw=1.2,
                          label=f"{STYLES[style]}, analysis")
                axis.plot(*curve(virtual, measured, architecture, style), marker, color=colour, ms=6,
                          mfc="white", label=f"{STYLES[style]}, virtual time")
                if not sockets:
                    continue
                axis.plot(*curve(sockets, predicted, architecture, style), "_", color=colour, ms=9)
                if i == 1:
                    axis.plot(*curve(sockets, measured, architecture, style), marker, color=colour,
                              ms=4, label=f"{STYLES[style]}, sockets")
                    continue
                for factor, name in zip((0.9, 1.1), TRIES):
                    for r in sockets:
                        t = r["measured"].get(name)
                        if (r["architecture"], r["style"]) == (architecture, style) and t:
                            axis.plot(1e3 * number(r["mean_age_s"]), factor * number(predicted(r)),
                                      "." if t["stable"] else "x", color=colour, ms=5)
            axis.set_title(architecture if i == 0 else "", fontsize=10)
            if i == 0:
                axis.set_yscale("log")
            else:
                axis.set_xlabel("mean age of the samples [ms]", fontsize=9)
            axis.grid(color="#e6e6e6", lw=.6)
        axes[i][0].set_ylabel(label, fontsize=9)
    entries = {}
    for axis in axes.flat:
        for handle, name in zip(*axis.get_legend_handles_labels()):
            entries.setdefault(name, handle)
    figure.legend(entries.values(), entries.keys(), loc="upper center", bbox_to_anchor=(0.5, 0.0),
                  fontsize=8, ncol=3, frameon=False)
    figure.savefig(PICTURE, dpi=90, bbox_inches="tight", metadata={"Software": None})


# ---- commands

def load(path):
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except (OSError, ValueError) as e:
        sys.exit(f"network_page.py: {path}: {e}")


def page(stored):
    lacking = [n for n in SWEEPS if n not in stored.get("virtual", {})]
    if lacking:
        sys.exit(f"network_page.py: docs/network.json lacks the virtual sweep {', '.join(lacking)}: "
                 "`network_page.py run TANDEM_PROGRAM`")
    with open(PAGE, encoding="utf-8") as file:
        text = file.read()
    if text.count(BEGIN) != 1 or text.count(END) != 1 or text.index(END) < text.index(BEGIN):
        sys.exit(f"network_page.py: docs/network.md needs one line each of\n{BEGIN}{END}")
    made = text[:text.index(BEGIN)] + section(stored) + text[text.index(END) + len(END):]
    return text, made


def main():
    words = sys.argv[1:]
    if words[:1] == ["run"] and len(words) == 2:
        stored = load(STORE) if os.path.exists(STORE) else {}
        for name in SWEEPS:
            command = [words[1], "netem", "--virtual", "--sweep", name, "--json", "-"]
            print("--", *command, file=sys.stderr)
            out = subprocess.run(command, stdout=subprocess.PIPE, text=True)
            if not out.stdout.startswith("{"):
                sys.exit(f"network_page.py: {' '.join(command)} printed no JSON")
            take(stored, json.loads(out.stdout), name)
        keep(stored)
    elif words[:1] == ["take"] and len(words) > 1:
        stored = load(STORE) if os.path.exists(STORE) else {}
        for path in words[1:]:
            take(stored, load(path), path)
        keep(stored)
    elif words == ["write"]:
        _, made = page(load(STORE))
        with open(PAGE, "w", encoding="utf-8") as file:
            file.write(made)
    elif words == ["check"]:
        text, made = page(load(STORE))
        if text != made:
            sys.exit("network_page.py: docs/network.md is not what docs/network.json says; run "
                     "`scripts/network_page.py write`")
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
