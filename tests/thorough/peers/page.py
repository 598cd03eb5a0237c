"""The page docs/peers/README.md, its pictures, and what is kept of each part."""
import json
import math
import tomllib
from pathlib import Path

import numpy as np

STYLE = (
    ".plot{--ink:#1f2328;--faint:#6e7781;--grid:#d8dee4;--paper:#fff;--c0:#0072b2;--c1:#d55e00;--c2:#009e73;--c3:#aa4499;--c4:#b58900}"
    "@media(prefers-color-scheme:dark){.plot{--ink:#e6edf3;--faint:#9198a1;--grid:#30363d;--paper:#0d1117;--c0:#56b4e9;--c1:#ff8c42;--c2:#3ddc97;"
    "--c3:#e58fc8;--c4:#f0c808}}.plot text{font:12px system-ui,-apple-system,'Segoe UI',sans-serif;fill:var(--ink)}"
    ".plot .tick{fill:var(--faint);font-size:11px}.plot .title{font-weight:600;font-size:14px}.plot .grid{stroke:var(--grid);stroke-width:1}"
    ".plot .curve{fill:none;stroke-width:1.4;stroke-linejoin:round}"
)
# Share of the held-out error from which another tool is ahead.
AHEAD = 0.05
# Columns of the table of all sets: tools, and their short names.
IN_SUMMARY = {
    "SciPy, first order": "SciPy, first order", "SciPy, friction by direction": "SciPy, by direction", "MuJoCo sysid, hinge": "MuJoCo sysid",
    "motorlab, nominal": "motorlab, nominal", "motorlab, re-identified": "re-identified", "motorlab, with effects": "with effects",
}  # fmt: skip
# Pixels of a picture, of its left margin and of a bar's row.
WIDTH, LEFT, ROW = 860, 270, 22
# Points of a curve at most.
POINTS = 400
# Colours by the beginning of a tool's name. In the lower panel the best of each is drawn.
COLOURS = {"SciPy": "--c0", "solve_ivp": "--c0", "NumPy": "--c0", "MuJoCo": "--c2", "motorlab": "--c1", "IDIM": "--c4", "M": "--c3"}


def family(tool):
    return next(name for name in COLOURS if tool.startswith(name))


def figure(value):
    """Three digits."""
    if not math.isfinite(value):
        return "diverges"
    if value >= 1000:
        return f"{value:,.0f}"
    return f"{value:.3g}"


def picture(title, rows, unit, curves, shares=False):
    """Held-out errors as bars on a logarithmic axis, or shares of 100 %, and beneath the errors of the best of each tool over the time of one segment.

    `rows` are names with values, `curves` names with times and errors.
    """
    values = [value for _, value in rows if math.isfinite(value)]
    low, high = 0.8 * min(values), 1.25 * max(values)
    part = lambda value: value / 100 if shares else math.log(value / low) / math.log(high / low)  # noqa: E731
    x = lambda value: LEFT + (WIDTH - LEFT - 90) * part(value)  # noqa: E731
    top = 44
    height = top + ROW * len(rows) + 24 + (250 if curves else 0)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" class="plot" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{title}"><style>{STYLE}</style>']
    out.append('<rect width="100%" height="100%" fill="var(--paper)"/>')
    out.append(f'<text class="title" x="16" y="22">{title}{"" if shares else " (logarithmic axis)"}</text>')
    for k, (name, value) in enumerate(rows):
        y = top + ROW * k
        end = x(value) if math.isfinite(value) else WIDTH - 90
        out.append(f'<text x="{LEFT - 10}" y="{y + 13}" text-anchor="end">{name}</text>')
        out.append(f'<rect x="{LEFT}" y="{y}" width="{end - LEFT:.1f}" height="{ROW - 6}" fill="var({COLOURS[family(name)]})"/>')
        out.append(f'<text x="{end + 6:.1f}" y="{y + 13}">{figure(value)} {unit}</text>')
    if curves:
        out += lines(curves, top + ROW * len(rows) + 34, unit)
    return "\n".join(out) + "\n</svg>\n"


def lines(curves, top, unit):
    """A panel with the errors over time."""
    bottom, left, right = top + 170, 64, WIDTH - 24
    last = max(times[-1] for _, times, _ in curves)
    sizes = np.concatenate([np.abs(errors) for _, _, errors in curves])
    most = float(np.max(sizes)) or 1.0
    x = lambda t: left + (right - left) * t / last  # noqa: E731
    y = lambda e: (top + bottom) / 2 - (bottom - top) / 2 * e / most  # noqa: E731
    out = []
    for value in (-most, 0.0, most):
        out.append(f'<path class="grid" d="M{left} {y(value):.1f}H{right}"/>')
        out.append(f'<text class="tick" x="{left - 6}" y="{y(value) + 4:.1f}" text-anchor="end">{figure(value) if value >= 0 else "-" + figure(-value)}</text>')
    for k in range(5):
        t = last * k / 4
        out.append(f'<text class="tick" x="{x(t):.1f}" y="{bottom + 16}" text-anchor="middle">{t:.3g} s</text>')
    at = left
    for name, times, errors in curves:
        every = max(1, len(times) // POINTS)
        path = "L".join(f"{x(t):.1f} {y(e):.1f}" for t, e in zip(times[::every], errors[::every]))
        colour = COLOURS[family(name)]
        out.append(f'<path class="curve" d="M{path}" stroke="var({colour})"/>')
        out.append(f'<path class="curve" d="M{at} {bottom + 36}h20" stroke="var({colour})" style="stroke-width:3"/><text x="{at + 26}" y="{bottom + 40}">{name}</text>')
        at += 40 + 7 * len(name)
    out.append(f'<text class="tick" x="{left}" y="{top - 8}">error over a held-out segment ({unit})</text>')
    return out


def best_of_each(rows):
    """The row of each tool with the least held-out error."""
    best = {}
    for row in rows:
        if row.errors is not None and math.isfinite(row.held) and (family(row.tool) not in best or row.held < best[family(row.tool)].held):
            best[family(row.tool)] = row
    return list(best.values())


def curves(rows, held, scale=1.0):
    """Errors of the best of each tool over the held-out segment in which they are of middle size."""
    drawn = best_of_each(rows)
    if not drawn:
        return []
    ends = np.cumsum([len(times) - held.first for times in held.times])
    pieces = [np.split(row.errors, ends[:-1]) for row in drawn]
    sizes = [np.median([np.sqrt(np.mean(piece[k] ** 2)) for piece in pieces]) for k in range(len(ends))]
    k = int(np.argsort(sizes)[len(sizes) // 2])
    return [(row.tool, held.times[k][held.first :], piece[k] * scale) for row, piece in zip(drawn, pieces)]


def table(rows, unit, scale=1.0, extra=None):
    """The table of a set; beside each held-out error its ratio to that of motorlab with effects. `extra` is a further column."""
    ours = next(row.held for row in reversed(rows) if row.tool.startswith("motorlab"))
    heads = ["tool", "given", "free parameters", f"fitted ({unit} RMS)", f"held out ({unit} RMS)", "ratio to motorlab with effects"]
    heads += [extra[0]] if extra else []
    heads += ["processor time (s)", "lines typed"]
    out = ["| " + " | ".join(heads) + " |", "|" + " --- |" * len(heads)]
    for k, row in enumerate(rows):
        name = row.tool + (f" ({row.note})" if row.note else "")
        ratio = figure(row.held / ours) if math.isfinite(row.held) else ""
        cells = [name, row.given, row.free, figure(row.fitted * scale), figure(row.held * scale), ratio]
        cells += [extra[1][k]] if extra else []
        cells += [figure(row.cpu_s) if row.cpu_s else "", row.lines]
        out.append("| " + " | ".join(map(str, cells)) + " |")
    return out


def ahead(name, rows):
    """Who is ahead of motorlab with effects by more than 5 %, and why as far as it was found (why.toml), or what else limits a figure."""
    ours = next(row.held for row in reversed(rows) if row.tool.startswith("motorlab"))
    better = [row for row in rows if row.held < ours / (1 + AHEAD) and not row.tool.startswith("motorlab")]
    why = tomllib.loads((Path(__file__).parent / "why.toml").read_text()).get(name)
    note = f" {why}" if why else ""
    if not better:
        return ["", f"No other tool is ahead of motorlab with effects by more than 5 %.{note}"]
    said = ", ".join(f"{row.tool} by {100 * (1 - row.held / ours):.0f} %" for row in better)
    return ["", f"Ahead of motorlab with effects by more than 5 %: {said}.{note}"]


def summary(rows, unit, scale=1.0):
    """Held-out errors by tool, for the table of all sets."""
    return {"unit": unit, "held": {row.tool: figure(row.held * scale) for row in rows}}


def keep(out, part, text, drawing, short=None):
    """The text of a part, for the page, its picture, and its row in the table of all sets."""
    file = out / "found.json"
    found = json.loads(file.read_text()) if file.exists() else {}
    found[part] = {"text": text, "summary": short}
    file.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n")
    (out / f"{part}.svg").write_text(drawing)


def write(out, parts):
    """The page, of what is kept."""
    found = json.loads((out / "found.json").read_text())
    head = (Path(__file__).parent / "head.md").read_text().rstrip()
    rows = ["| set | " + " | ".join(IN_SUMMARY.values()) + " | unit |", "|" + " --- |" * (len(IN_SUMMARY) + 2)]
    for part in parts:
        if short := found.get(part, {}).get("summary"):
            cells = [f"[{part}](#{part})", *(short["held"].get(tool, "") for tool in IN_SUMMARY), short["unit"]]
            rows.append("| " + " | ".join(cells) + " |")
    texts = [head, "\n".join(rows)] + [found[part]["text"] for part in parts if part in found]
    (out / "README.md").write_text("\n\n".join(texts) + "\n")
