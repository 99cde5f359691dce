"""Line plots side by side in one SVG file, without further packages."""
import math

PANEL = (380, 300)
MARGIN = (60, 40)
LEGEND = 18


class Axis:
    """Logarithmic or linear, from data to pixels."""

    def __init__(self, values, begin, end, logarithmic):
        self.logarithmic = logarithmic
        self.begin, self.end = begin, end
        low, high = min(values), max(values)
        if logarithmic:
            low, high = math.log10(low), math.log10(high)
        room = 0.05 * (high - low) or 1.0
        self.low, self.high = low - room, high + room

    def __call__(self, value):
        at = math.log10(value) if self.logarithmic else value
        return self.begin + (self.end - self.begin) * (at - self.low) / (self.high - self.low)

    def ticks(self):
        if not self.logarithmic:
            return [v for v in range(0, 200, 10) if self.low <= v <= self.high]
        decades = range(math.floor(self.low), math.ceil(self.high) + 1)
        steps = (1,) if self.high - self.low > 2.5 else (1, 2, 3, 5, 7)
        marks = [m * 10.0 ** d for d in decades for m in steps]
        return [v for v in marks if self.low <= math.log10(v) <= self.high]


def panel(curves, colours, left, label, title="", y_logarithmic=False):
    """curves: {name: [(x, y)]}; x is logarithmic."""
    points = [p for curve in curves.values() for p in curve]
    bottom, top = MARGIN[1] + PANEL[1], MARGIN[1]
    x = Axis([p[0] for p in points], left, left + PANEL[0], True)
    y = Axis([p[1] for p in points], bottom, top, y_logarithmic)
    out = [f'<rect x="{left}" y="{top}" width="{PANEL[0]}" height="{PANEL[1]}" fill="none" stroke="#333"/>']
    for v in x.ticks():
        out.append(f'<line x1="{x(v):.1f}" x2="{x(v):.1f}" y1="{top}" y2="{bottom}" stroke="#ddd"/>')
        out.append(f'<text x="{x(v):.1f}" y="{bottom + 16}" text-anchor="middle">{v:g}</text>')
    for v in y.ticks():
        out.append(f'<line x1="{left}" x2="{left + PANEL[0]}" y1="{y(v):.1f}" y2="{y(v):.1f}" stroke="#ddd"/>')
        out.append(f'<text x="{left - 6}" y="{y(v) + 4:.1f}" text-anchor="end">{v:g}</text>')
    for name, curve in curves.items():
        line = " ".join(f"{x(p[0]):.1f},{y(p[1]):.1f}" for p in curve)
        out.append(f'<polyline points="{line}" fill="none" stroke="{colours[name]}" stroke-width="2"/>')
        out.extend(f'<circle cx="{x(p[0]):.1f}" cy="{y(p[1]):.1f}" r="3" fill="{colours[name]}"/>' for p in curve)
    out.append(f'<text x="{left + PANEL[0] / 2}" y="{bottom + 36}" text-anchor="middle">{label}</text>')
    out.append(f'<text x="{left + PANEL[0] / 2}" y="{top - 6}" text-anchor="middle">{title}</text>')
    return out


def place(index):
    """The left border of a panel."""
    return MARGIN[0] + index * (PANEL[0] + MARGIN[0])


def document(panels, colours, title):
    """panels: lists of elements by panel(), in order; the legend stands below."""
    names = list(colours)
    columns = 3 if len(names) > 3 else len(names)
    rows = (len(names) + columns - 1) // columns
    width = place(len(panels)) + 20
    legend_top = MARGIN[1] + PANEL[1] + 60
    height = legend_top + rows * LEGEND + 6
    parts = [f'<text x="{MARGIN[0]}" y="18">{title}</text>']
    parts.extend(element for one in panels for element in one)
    for i, name in enumerate(names):
        x = MARGIN[0] + (i % columns) * (width - MARGIN[0]) // columns
        y = legend_top + i // columns * LEGEND
        parts.append(f'<line x1="{x}" x2="{x + 24}" y1="{y}" y2="{y}" stroke="{colours[name]}" stroke-width="2"/>')
        parts.append(f'<text x="{x + 30}" y="{y + 4}">{name}</text>')
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            f'font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="#fff"/>'
            + "\n".join(parts) + "</svg>\n")
