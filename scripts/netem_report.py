#!/usr/bin/python3
"""Makes one self-contained page of a sweep.  netem_report.py RESULTS.json REPORT.html

RESULTS.json is what `tandem netem --json` writes. Every number on the page is from it; pictures are
drawn with matplotlib and stand in the page as SVG.
"""
import html
import io
import json
import math
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

STYLES = {"hold": ("#1f77b4", "o"), "compensated": ("#d95f02", "s"), "extrapolate": ("#2a9d4a", "^"),
          "": ("#555555", "D")}
SPOKEN = {"extrapolate": "extrapolated", "": "scene"}
CSS = """
body { font: 15px/1.45 system-ui, sans-serif; color: #1c1c1c; max-width: 1560px; margin: 2em auto;
       padding: 0 1em; }
h1 { font-size: 1.6em; margin-bottom: .1em } h2 { margin-top: 1.8em; border-bottom: 1px solid #ccc }
.note { color: #555 } svg { max-width: min(100%, 1100px); height: auto }
p, ul { max-width: 1100px } table { border-collapse: collapse; font-size: 12px; margin: .6em 0 }
th, td { padding: 2px 6px; text-align: right; border-bottom: 1px solid #e4e4e4; white-space: nowrap }
th { background: #f3f3f3; vertical-align: bottom; white-space: normal; max-width: 8em }
td:first-child, th:first-child, td.l, th.l { text-align: left }
.bad { color: #b00020; font-weight: 600 } .good { color: #176b2c } .near { color: #8a6d00 }
.wide { overflow-x: auto } pre { background: #f6f6f6; padding: .8em; overflow-x: auto;
  font-size: 12px } .card { background: #f6f8fa; border: 1px solid #dde; padding: .6em 1em }
li { margin: .35em 0 } td.best { font-weight: 700; background: #eaf5ec }
"""


def number(x):
    """A JSON number, null or word as a float."""
    if x is None:
        return math.nan
    if x == "infinite":
        return math.inf
    return float(x)


def cell(x, digits=3, factor=1.0):
    x = number(x)
    if math.isnan(x):
        return "–"
    if math.isinf(x):
        return "&gt; 64×"
    x = 0.0 if abs(x) < 1e-9 else x  # rounding has a sign
    return f"{x * factor:.{digits}g}"


def whole(x):
    """A coupling to three digits, without an exponent."""
    x = number(x)
    if not math.isfinite(x) or abs(x) < 1000:
        return cell(x)
    unit = 10 ** (math.floor(math.log10(x)) - 2)
    return f"{unit * round(x / unit):.0f}"


def sites(result, key, how):
    values = [number(s.get(key)) for s in result["measured"]["sites"]]
    values = [v for v in values if not math.isnan(v)]
    return how(values) if values else math.nan


def mean(values):
    return sum(values) / len(values)


def groups(results):
    """Architectures in order, each with its labels in order and its results by (style, label)."""
    out = {}
    for r in results:
        labels, table = out.setdefault(r["architecture"], ([], {}))
        if r["label"] not in labels:
            labels.append(r["label"])
        table[r["style"], r["label"]] = r
    values = {r["label"]: r.get("value") for r in results}
    if all(v is not None for v in values.values()):  # quick sweeps come in no order
        for labels, _ in out.values():
            labels.sort(key=values.get)
    return out


def ok(r):
    return "failed" not in r


def attempts(r):
    """The couplings that sockets were tried with on both sides of the predicted one: (k, stable)."""
    k = number(r["predicted"].get("largest_coupling_n_per_m"))
    out = []
    for factor, key in ((0.9, "at_0.9_of_predicted"), (1.1, "at_1.1_of_predicted")):
        attempt = r["measured"].get(key)
        if attempt and attempt["judged"] and math.isfinite(k):
            out.append((factor * k, attempt["stable"]))
    return out


def picture(results, title, unit, measured, predicted=None, log=False, only_stable=True, line=None,
            same=True, tried=None):
    """One axis for each architecture; predicted as dashes joined by lines, measured as markers, what
    was `tried` as dots (stable) and crosses (not)."""
    parts = {name: part for name, part in groups(results).items()
             if any(math.isfinite(number(measured(r))) or (tried and tried(r))
                    for r in part[1].values() if ok(r))}
    if not parts:
        return ""
    figure, axes = plt.subplots(1, len(parts), figsize=(3.75 * len(parts) + 0.6, 3.5), squeeze=False,
                                sharey=same, layout="constrained")
    drawn = False

    def shown(x):
        x = number(x)
        return math.nan if log and x <= 0 else x

    for axis, (architecture, (labels, table)) in zip(axes[0], parts.items()):
        styles = [s for s in STYLES if any((s, l) in table for l in labels)]
        for k, style in enumerate(styles):
            colour, marker = STYLES[style]
            shift = 0.12 * (k - (len(styles) - 1) / 2)
            x, m, px, p, ex = [], [], [], [], []
            name = SPOKEN.get(style, style)
            sides = {True: ([], []), False: ([], [])}
            for i, label in enumerate(labels):
                r = table.get((style, label))
                if r is None or not ok(r):
                    continue
                if predicted is not None:
                    px.append(i + shift)
                    p.append(shown(predicted(r)))
                for value, held in tried(r) if tried else []:
                    sides[held][0].append(i + shift)
                    sides[held][1].append(shown(value))
                    drawn = True
                stable = r["measured"]["stability"]["stable"]
                value = shown(measured(r))
                if math.isfinite(value) and (stable or not only_stable):
                    x.append(i + shift)
                    m.append(value)
                    drawn = True
                elif not stable and only_stable:
                    ex.append(i + shift)
            if predicted is not None:
                axis.plot(px, [v if math.isfinite(v) else math.nan for v in p], "-", color=colour,
                          lw=1.2, alpha=.75, marker="_", ms=15, mew=1.8,
                          label=f"{name}, predicted")
            if x:
                axis.plot(x, m, marker, color=colour, ms=5.5, mfc="white" if predicted else colour,
                          ls="" if predicted else "-", lw=1, label=f"{name}, measured")
            for held, (tx, ty) in sides.items():
                if tx:
                    axis.plot(tx, ty, "." if held else "x", color=colour, ms=7 if held else 5,
                              label=f"{name}, tried: {'stable' if held else 'not stable'}")
            if ex:
                axis.plot(ex, [1.0 - 0.035 * (k + 1)] * len(ex), "x", color=colour, ms=6,
                          transform=axis.get_xaxis_transform(), label=f"{name}, not stable")
        if line is not None:
            axis.axhline(line, color="#999", lw=.8, ls="--")
        axis.set_title(architecture, fontsize=10)
        axis.set_xticks(range(len(labels)), labels, rotation=40, ha="right", fontsize=8)
        axis.set_xlim(-.5, len(labels) - .5)
        axis.grid(axis="y", color="#e6e6e6", lw=.6)
        if log:
            axis.set_yscale("log")
        for side in ("top", "right"):
            axis.spines[side].set_visible(False)
    if not drawn:
        plt.close(figure)
        return ""
    axes[0][0].set_ylabel(unit, fontsize=9)
    entries = {}
    for axis in axes[0]:
        for handle, label in zip(*axis.get_legend_handles_labels()):
            entries.setdefault(label, handle)
    figure.legend(entries.values(), entries.keys(), loc="upper center", bbox_to_anchor=(0.5, 0.01),
                  fontsize=8, ncol=min(len(entries), 6), frameon=False)
    figure.suptitle(title, fontsize=11)
    return as_svg(figure)


def as_svg(figure):
    """The figure as an SVG element whose ids no other picture of the page has."""
    as_svg.count = getattr(as_svg, "count", 0) + 1
    own = f"p{as_svg.count}-"
    text = io.StringIO()
    figure.savefig(text, format="svg", bbox_inches="tight", metadata={"Date": None, "Creator": None})
    plt.close(figure)
    svg = text.getvalue()
    svg = svg[svg.index("<svg"):]
    svg = svg.replace(' id="', f' id="{own}').replace("url(#", f"url(#{own}")
    svg = svg.replace('href="#', f'href="#{own}')
    return "<div>" + svg + "</div>"


def verdict(stability):
    if not stability["judged"]:
        return "<td>–</td>"
    if stability["stable"]:
        return '<td class="good">stable</td>'
    return f'<td class="bad" title="{html.escape(stability.get("reason", ""))}">not stable</td>'


def main_table(labels, table):
    rows = []
    real_tries = any("at_0.9_of_predicted" in r["measured"] or "at_1.1_of_predicted" in r["measured"]
                     for r in table.values() if ok(r))
    for label in labels:
        for style in STYLES:
            r = table.get((style, label))
            if r is None:
                continue
            first = f"<td>{html.escape(label)}</td><td class=l>{SPOKEN.get(style, style)}</td>"
            if not ok(r):
                rows.append(f'<tr>{first}<td class="bad l" colspan=18>failed: '
                            f'{html.escape(r["failed"][:300])}</td></tr>')
                continue
            p, m = r["predicted"], r["measured"]
            if p["judged"]:
                side = ("good", "stable") if p["stable"] else ("bad", "not stable")
                near = ' <span class=near title="within 10 % of the boundary">~</span>' \
                    if p["near_boundary"] else ""
                said = f'<td class="{side[0]}">{side[1]}{near}</td>'
            else:
                said = f'<td title="{html.escape(p.get("note", ""))}">–</td>'
            tries = ""
            if real_tries:
                for key in ("at_0.9_of_predicted", "at_1.1_of_predicted"):
                    tries += verdict(m[key]) if key in m else "<td>–</td>"
            rows.append(
                f"<tr>{first}<td>{cell(r['mean_age_s'], 3, 1e3)}</td>{said}{verdict(m['stability'])}"
                f"<td>{cell(p.get('growth_per_packet'), 6)}</td>"
                f"<td>{cell(m['stability']['growth_per_packet'], 6) if not m['stability'].get('growth_per_packet') == 'infinite' else '∞'}</td>"
                f"<td>{whole(p.get('largest_coupling_n_per_m'))}</td>"
                f"<td>{whole(m['largest_coupling_n_per_m'])}</td>{tries}"
                f"<td>{cell(p.get('drag_n_s_per_m'))}</td><td>{cell(m['drag_n_s_per_m'])}</td>"
                f"<td>{cell(p.get('rendered_stiffness_n_per_m'), 4)}</td>"
                f"<td>{cell(m['rendered_stiffness_n_per_m'], 4)}</td>"
                f"<td>{cell(sites(r, 'force_error_rms_n', mean))}</td>"
                f"<td>{cell(sites(r, 'force_error_rms_weber', mean))}</td>"
                f"<td>{cell(m['gap_rms_m'], 3, 1e3)}</td>"
                f"<td>{cell(m['gap_99.9_percent_m'], 3, 1e3)}</td>"
                f"<td>{cell(sites(r, 'network_gave_most_j', max), 3, 1e3)}</td>"
                f"<td>{cell(m['motion_to_force_s'], 3, 1e3)}</td>"
                f"<td>{cell(sites(r, 'packets_per_s', mean), 4)}</td>"
                f"<td>{cell(sites(r, 'bytes_per_s', mean), 5)}</td></tr>")
    coupling = next((r["coupling_name"] for r in table.values()), "k")
    tries = "<th>at 0.9 predicted</th><th>at 1.1 predicted</th>" if real_tries else ""
    return (f"<div class=wide><table><tr><th>condition</th><th class=l>style</th><th>mean age "
            f"[ms]</th><th>predicted</th><th>measured</th><th>growth a packet, predicted</th>"
            f"<th>measured</th><th>largest stable {coupling} [N/m], predicted</th><th>by search</th>"
            f"{tries}<th>drag [N s/m], predicted</th><th>measured</th><th>rendered stiffness [N/m], "
            f"predicted</th><th>measured</th><th>force error [N]</th><th>force error [Weber]</th>"
            f"<th>gap rms [mm]</th><th>gap 99.9 % [mm]</th><th>network gave [mJ]</th><th>motion to "
            f"force [ms]</th><th>packets/s a site</th><th>bytes/s a site</th></tr>"
            + "".join(rows) + "</table></div>")


def conditions(results):
    rows, seen = [], set()
    for r in results:
        key = (r["label"], r["network"]["there"], r["network"]["back"])
        if key in seen:
            continue
        seen.add(key)
        rows.append(f"<tr><td>{html.escape(r['label'])}</td><td class=l>"
                    f"{html.escape(r['network']['there'])}</td><td class=l>"
                    f"{html.escape(r['network']['back'])}</td></tr>")
    return ("<table><tr><th>condition</th><th class=l>there (to the higher user; from the server)"
            "</th><th class=l>back</th></tr>" + "".join(rows) + "</table>")


def seen_links(data):
    rows, known = [], set()
    for r in data["results"]:
        for l in r["seen"]:
            if not l["sent"] or l["set"] in known:
                continue
            known.add(l["set"])
            n = l["sent"]
            rate = l.get("rate_bit_per_s")
            wrong = l["out_of_bounds"]
            verdict_ = "good>within" if not wrong else f"'bad l'>{html.escape('; '.join(wrong))}"
            rows.append(
                f"<tr><td>{html.escape(l['set'])}</td>"
                f"<td>{cell(l['delay_p50_expected_s'], 4, 1e3)}</td>"
                f"<td>{cell(l['delay_p50_s'], 4, 1e3)}</td>"
                f"<td>{cell(l['delay_sd_expected_s'], 3, 1e3)}</td>"
                f"<td>{cell(l['delay_sd_s'], 3, 1e3)}</td>"
                f"<td>{cell(l['loss_expected'], 3, 100)} ± {cell(l['loss_interval'], 2, 100)}</td>"
                f"<td>{cell(l['loss'], 3, 100)}</td>"
                f"<td>{cell(l['duplicates_expected'], 3, 100)}</td>"
                f"<td>{cell(l['duplicates'] / n, 3, 100)}</td>"
                f"<td>{cell(rate['set'] if rate else None, 4, 1e-3)}</td>"
                f"<td>{cell(rate['seen'] if rate else None, 4, 1e-3)}</td>"
                f"<td>{n}</td><td class={verdict_}</td></tr>")
    if not rows:
        return ""
    return ("<h2>The network as it was set and seen by tandem probe</h2><p class=note>One direction "
            "at a time, the other one clear; delay is the round trip less that of a clear network. "
            "Bounds: delay 0.3 ms at p50, standard deviation 10 % where it is more than 0.5 ms, loss "
            "and duplicates 99.9 % of chance, rate 5 %; what is drawn adds its own spread.</p>"
            "<div class=wide><table><tr><th>set</th><th>delay p50 [ms], set</th><th>seen</th>"
            "<th>sd [ms], set</th><th>seen</th><th>loss [%], set</th><th>seen</th><th>duplicates "
            "[%], set</th><th>seen</th><th>rate [kbit/s], set</th><th>seen</th><th>packets</th>"
            "<th class=l>bounds</th></tr>" + "".join(rows) + "</table></div>")


def sockets(data):
    """How samples came over in the sessions, and the three verdicts side by side."""
    def side(twin):
        if not twin or not twin["judged"]:
            return "<td>–</td>"
        return (f'<td class={"good" if twin["stable"] else "bad"}>'
                f'{"stable" if twin["stable"] else "not stable"}'
                f'{" ~" if twin["near_boundary"] else ""}</td>')
    rows = []
    for r in data["results"]:
        if not ok(r) or "virtual_time_over_recorded_packets" not in r:
            continue
        m, twin = r["measured"], r["virtual_time_over_recorded_packets"]
        links = ", ".join(f"{html.escape(l['from'])} → {html.escape(l['to'])} "
                          f"{cell(l['delay_ticks'], 3)}" for l in r["seen"][:4])
        more = " …" if len(r["seen"]) > 4 else ""
        row = f"<tr><td>{html.escape(r['name'])}</td><td class=l>{links}{more}</td>"
        for key in ("at_0.9_of_predicted", "at_1.1_of_predicted"):
            t = m.get(key)
            row += (f"<td>{cell(t['coupling_over_that_of_its_own_delays'], 3)}</td>{verdict(t)}"
                    f"{side(t['virtual_time'])}" if t else "<td>–</td>" * 3)
        row += (f"<td>{cell(r['predicted'].get('drag_n_s_per_m'))}</td>"
                f"<td>{cell(twin.get('drag_n_s_per_m'))}</td><td>{cell(m['drag_n_s_per_m'])}</td>"
                f"<td>{cell(r['missed_ticks_share'], 2, 100)}</td></tr>")
        rows.append(row)
    if not rows:
        return ""
    c = data["verdicts_compared"]
    return ("<h2>Sockets, virtual time and analysis</h2><p class=note>Virtual time runs each session "
            "again over the packets that it recorded, each with its own delay. The ratio is the "
            "coupling over the largest one that the analysis predicts from the delays of that very "
            f"run; between 0.9 and 1.1 it expects nothing. Compared: {c['with_analysis']} verdicts "
            f"with the analysis, {c['with_virtual_time']} with virtual time; {c['near_boundary']} "
            f"too near the boundary, {c['missed_ticks']} of sessions that missed more than 1 % of "
            "their ticks in two runs. ~: virtual time falls on the other side with 1.09 times more or "
            "less coupling.</p><div class=wide><table><tr><th>point</th><th class=l>slot to first "
            "use [ticks], mean</th><th>0.9: ratio</th><th>sockets</th><th>virtual</th><th>1.1: ratio"
            "</th><th>sockets</th><th>virtual</th><th>drag [N s/m]: analysis</th><th>virtual</th>"
            "<th>sockets</th><th>missed ticks [%]</th></tr>" + "".join(rows) + "</table></div>")


def which_wins(data):
    """The program's statement: how to read it, then for each architecture the numbers and sentences."""
    sentences = data["statement"]
    contests = data.get("contests", [])
    out = ["<h2>Which reconstruction wins where</h2><p class=note>Made from the numbers of this page. "]
    if not contests:
        return out[0] + "</p><ul>" + "".join(f"<li>{html.escape(s)}</li>" for s in sentences) + "</ul>"
    out.append(html.escape(sentences[0]) + " Green: best or alike; ~: within 10 % of the boundary.</p>")
    out += [f"<p class=card>{html.escape(s)}</p>" for s in sentences if s.startswith("In short")]
    order = ("hold", "compensated", "extrapolate")
    heads = "".join(f"<th>{SPOKEN.get(s, s)}</th>" for s in order)
    for c in contests:
        name = c["architecture"]
        out.append(f"<h3>{html.escape(name)}</h3><table><tr><th rowspan=2>{html.escape(data['knob'])}"
                   f"</th><th rowspan=2>mean age [ms]</th><th colspan=3>force error [Weber]</th>"
                   f"<th colspan=3>largest stable {c['coupling']} [N/m]</th></tr><tr>{heads}{heads}</tr>")
        for at in c["at"]:
            by = at.get("by", {})
            row = f"<tr><td>{html.escape(at['label'])}</td><td>{cell(at['mean_age_s'], 3, 1e3)}</td>"
            for s in order:
                x = by.get(s)
                best = " class=best" if s in at["least_force_error"] else ""
                if x and x["judged"] and not x["stable"]:
                    row += "<td class=bad>not stable"
                else:
                    row += f"<td{best}>{cell(x['force_error_rms_weber'] if x else None)}"
                row += (" ~" if x and x["near_boundary"] else "") + "</td>"
            for s in order:
                x = by.get(s)
                best = " class=best" if s in at["largest_coupling"] else ""
                row += f"<td{best}>{whole(x['largest_coupling_n_per_m'] if x else None)}</td>"
            out.append(row + "</tr>")
        out.append("</table><ul>")
        mine = [s for s in sentences[1:] if s.startswith(name + ". ")]
        out += [f"<li>{html.escape(s[len(name) + 2:])}</li>" for s in mine]
        out.append("</ul>")
    return "".join(out)


def boundaries(data):
    def ms(x):
        x = number(x)
        return "–" if math.isnan(x) else "none up to 100" if math.isinf(x) else f"{x * 1e3:.2f}"
    if not data["delay_boundaries"]:
        return ""
    rows = "".join(
        f"<tr><td>{b['scene']}</td><td>{ms(b['predicted_s'])}</td><td>{ms(b['virtual_s'])}</td>"
        f"<td>{ms(b['real_stable_s'])}</td><td>{ms(b['real_not_stable_s'])}</td></tr>"
        for b in data["delay_boundaries"])
    return ("<h2>Boundary in delay of the thesis' boxes</h2><p>Shortest one-way delay, the same both "
            "ways and in whole ticks, with which the grasp is no longer stable [ms].</p><table><tr>"
            "<th>scene</th><th>analysis, linearised at the grasp</th><th>virtual time</th><th>sockets:"
            " stable at</th><th>sockets: not stable at</th></tr>" + rows + "</table>")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1], encoding="utf-8") as file:
        data = json.load(file)
    results = data["results"]
    measured = lambda *keys: lambda r: _get(r["measured"], keys)  # noqa: E731
    predicted = lambda *keys: lambda r: _get(r["predicted"], keys)  # noqa: E731
    name = next((r["coupling_name"] for r in results), "k")
    names = "k_2 (central), k_o" if any(r["coupling_name"] != name for r in results) else name
    pictures = [
        picture(results, "Growth a packet period: below 1 is stable", "growth",
                measured("stability", "growth_per_packet"), predicted("growth_per_packet"),
                only_stable=False, line=1.0),
        picture(results, f"Largest stable coupling {names}", "N/m",
                measured("largest_coupling_n_per_m"), predicted("largest_coupling_n_per_m"), log=True,
                only_stable=False, tried=attempts),
        picture(results, "Drag of one hand alone in free motion", "N s/m",
                measured("drag_n_s_per_m"), predicted("drag_n_s_per_m"), line=0.0,
                same=False),
        picture(results, "Rendered stiffness, the other hands held", "N/m",
                measured("rendered_stiffness_n_per_m"), predicted("rendered_stiffness_n_per_m"),
                same=False),
        picture(results, "Force error against the ideal twin, in Weber units", "RMS / max(|F|, 0.5 N)",
                lambda r: sites(r, "force_error_rms_weber", mean), log=True),
        picture(results, "Distance of the copies while carried", "RMS [m]", measured("gap_rms_m"),
                log=True),
        picture(results, "Most energy that a network port gave while carried", "J",
                lambda r: sites(r, "network_gave_most_j", max)),
        picture(results, "From one hand's motion to the other's force", "s",
                measured("motion_to_force_s")),
    ]
    machine = data["machine"]
    wrong = data["disagreement_list"]
    c = data["verdicts_compared"]
    page = [
        "<!doctype html><html lang=en><head><meta charset=utf-8>",
        f"<title>Tandem: sweep {html.escape(data['sweep'])}</title><style>{CSS}</style></head><body>",
        f"<h1>{html.escape(data['title'])}</h1>",
        f"<p class=note>Sweep <b>{html.escape(data['sweep'])}</b> on {data['on']}, seed "
        f"{data['seed']}; {data['session_s']:.0f} s of sessions in {data['wall_s']:.1f} s "
        f"({data['times_real_time']:.3g} times real time). Tandem {data['revision']}, {data['date']}."
        f"<br>{html.escape(machine['processor'])}, {machine['processors']} processors, "
        f"{html.escape(machine['kernel'])}."
        + (f"<br>{html.escape(data['granted'])}" if data["granted"] else "") + "</p>",
        f"<p class=card><b>{data['points']} points, {data['disagreements']} disagreements</b> between "
        f"measured and predicted where the prediction is exact, {data['approximate_disagreements']} where "
        f"it is not (a steady network of the same mean age stands for jitter or loss; or nodes "
        f"extrapolated by wrong ages); "
        f"{data['near_boundary']} points within 10 % of the boundary, "
        f"{data['failed']} failed."
        + (f" <b>Compared: {c['with_analysis']} verdicts with the analysis, {c['with_virtual_time']} "
           f"with virtual time; {c['missed_ticks']} not, because the machine missed over 1 % of the "
           "ticks.</b>" if "sockets" in data["on"] else "") + "</p>",
    ]
    if wrong:
        page.append("<ul>" + "".join(
            f"<li{' class=bad' if d['exact'] else ''}>{'' if d['exact'] else '(approximate) '}"
            f"{html.escape(d['point'])}: {html.escape(d['what'])}</li>" for d in wrong)
            + "</ul>")
    if data["statement"]:
        page.append(which_wins(data))
    page.append("<h2>Pictures</h2><p class=note>Dashes, joined by lines: predicted by the analysis. "
                "Hollow markers: measured. Crosses at the top: not stable, so not comparable. "
                + ("Couplings tried on sockets, 0.9 and 1.1 times the predicted: dots stable, crosses "
                   "not. " if any(attempts(r) for r in results if ok(r)) else "")
                + "Compensation is tuned at every condition to leave 5 % of the drag predicted for "
                "hold.</p>")
    page += [p for p in pictures if p]
    page.append(boundaries(data))
    page.append("<h2>Conditions</h2>" + conditions(results))
    page.append(seen_links(data))
    page.append(sockets(data))
    if data["left_out"]:
        page.append("<p>Left out: " + html.escape("; ".join(data["left_out"])) + "</p>")
    for architecture, (labels, table) in groups(results).items():
        page.append(f"<h2>{html.escape(architecture)}</h2>" + main_table(labels, table))
    page.append(
        "<h2>How it is measured</h2><ul>"
        "<li>Stable or not: free hands, pushed once back and forth. The widest range of any distance "
        "(hand from object, copy from copy) in each of 16 windows is the envelope; not stable if a "
        "distance leaves 1 m, if the envelope of the second half grows by more than 2 % a second and "
        "10 % in all, or if the last quarter moves more than 5 times as far as the start. On sockets "
        "ranges below 1e-5 of the widest tell nothing, and a hand whose drag is below -0.05 N s/m is "
        "not stable: it speeds up by itself.</li>"
        "<li>Largest stable coupling: by search of such runs in virtual time, up from a 64th of the "
        "scene's, to 1 %; of sockets over the packets that they recorded.</li>"
        "<li>Drag: one hand alone under a constant force, the end of its velocity from three means.</li>"
        "<li>Force error, gap, energy: the first hand leads along 0.05 sin(2 t) m, the others hold "
        "back; against the same hands with a packet every tick that takes no time.</li>"
        "<li>Rendered stiffness: one hand led 5 mm at 0.5 Hz, the others held by 20 kN/m. Motion to "
        "force: the first hand moved by 5 mm within 20 ms, until the second feels it.</li>"
        "<li>Predicted: from the linear map over a packet period with the delays in whole ticks. A "
        "network with jitter or loss is replaced by a steady one of the same mean age.</li></ul>")
    page.append("<h2>Scenes</h2>")
    for r in results:
        text = data["scenes"].pop(r["hash"], None)
        if text is None:
            continue
        edits = "  ".join(r["edits"])
        page.append(f"<details><summary>{html.escape(r['name'])} <span class=note>{r['scene']} "
                    f"{html.escape(edits)} · hash {r['hash']}</span></summary>"
                    f"<pre>{html.escape(text)}</pre></details>")
    page.append("</body></html>\n")
    try:
        with open(sys.argv[2], "w", encoding="utf-8") as file:
            file.write("\n".join(page))
    except OSError as error:
        print(f"cannot write all of {sys.argv[2]}: {error.strerror}", file=sys.stderr)
        sys.exit(2)


def _get(tree, keys):
    for key in keys:
        tree = tree.get(key) if tree is not None else None
    return tree


if __name__ == "__main__":
    main()
