"""A dot plot of ratios to `input` with their intervals, as SVG: one row per method or case, one panel per metric."""
import html

from markdown_tables import estimate

ROW, TOP, LABELS, PANEL, GAP = 20, 44, 250, 180, 44
LAST = 1.5  # The right edge of a panel; larger values are written there.
FONT = 'font-family="sans-serif" font-size="12" fill="#1d2430"'
# Oracles, which are given part of the answer, are drawn lighter.
COLOURS = {False: "#0072b2", True: "#8a93a0"}


def text(x, y, words, anchor="start", extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{extra}>{html.escape(words)}</text>'


def frame(left, bottom, heading):
    """A panel's heading, grid and axis; the line at 1 is the unchanged input."""
    parts = [text(left + PANEL / 2, 18, heading, "middle", ' font-weight="bold"')]
    for tick in (0.0, 0.5, 1.0, 1.5):
        x = left + PANEL * tick / LAST
        colour, width = ("#1d2430", 1.2) if tick == 1 else ("#d5dae0", 1)
        parts += [f'<line x1="{x:.1f}" y1="{TOP - 8}" x2="{x:.1f}" y2="{bottom}" stroke="{colour}" stroke-width="{width}"/>',
                  text(x, bottom + 16, f"{tick:g}", "middle", ' font-size="11"')]
    return parts


def mark(left, y, found, colour):
    """A dot on its interval; an arrow and the value where both lie beyond the panel."""
    def place(value):
        return left + PANEL * min(max(value, 0), LAST) / LAST

    if found.value > LAST:
        return [text(left + PANEL, y + 4, f"{found.value:.2f} →", "end", f' fill="{colour}" font-size="11"')]
    parts = []
    if found.low is not None:
        parts.append(f'<line x1="{place(found.low):.1f}" y1="{y}" x2="{place(found.high):.1f}" y2="{y}" stroke="{colour}" '
                     'stroke-width="3" stroke-opacity="0.45"/>')
    return parts + [f'<circle cx="{place(found.value):.1f}" cy="{y}" r="4" fill="{colour}"/>']


def ratio_plot(rows, plot):
    """The SVG, or None if the table has nothing to show."""
    named = [(": ".join(filter(None, (row.get(label, "") for label in plot.labels))), row) for row in rows]
    named = [(name, row) for name, row in named if name not in ("input", "oracle-all")]
    columns = [column for column in plot.columns if any(column in row for _, row in named)]
    if not named or not columns:
        return None
    bottom = TOP + ROW * len(named)
    width = LABELS + len(columns) * (PANEL + GAP)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{bottom + 44}" '
             f'viewBox="0 0 {width} {bottom + 44}" {FONT}><rect width="100%" height="100%" fill="#fff"/>']
    lefts = [LABELS + i * (PANEL + GAP) for i in range(len(columns))]
    for column, left in zip(columns, lefts):
        parts += frame(left, bottom, column.split(" (")[0])
    for i, (name, row) in enumerate(named):
        y = TOP + ROW * i + ROW // 2
        colour = COLOURS[name.startswith("oracle-")]
        parts.append(text(LABELS - 12, y + 4, name, "end", f' fill="{colour}"'))
        for column, left in zip(columns, lefts):
            found = estimate(row.get(column, ""))
            parts += mark(left, y, found, colour) if found else []
    parts.append(text(width - 12, bottom + 36, "error over that of the unchanged input (line at 1), with 95 % intervals; "
                      "less is better", "end", ' font-size="11" fill="#4a5361"'))
    return "\n".join([*parts, "</svg>", ""])
