#!/usr/bin/env python3
"""Error of the collimated estimators over samples and over seconds, as one SVG file.

    build/release/bench_collimated --csv collimated.csv
    bench/collimated_plot.py collimated.csv collimated.svg
"""
import argparse
import csv
import math
import sys

COLOURS = {"RM": "#7f7f7f", "DS": "#1f77b4", "REES": "#2ca02c", "REDS": "#d62728", "WVDS": "#9467bd"}
PANEL = (380, 300)
MARGIN = (60, 40)


def read(path):
    """{estimator: [(samples, seconds, psnr)]}, in the order of the file."""
    curves = {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            curves.setdefault(row["estimator"], []).append(
                (float(row["samples"]), float(row["seconds"]), float(row["psnr_db"])))
    if not curves:
        raise ValueError(f"{path}: no rows")
    return curves


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
        marks = [m * 10.0 ** d for d in decades for m in (1, 2, 3, 5, 7)]
        return [v for v in marks if self.low <= math.log10(v) <= self.high]


def panel(curves, column, label, left):
    x = Axis([p[column] for c in curves.values() for p in c], left, left + PANEL[0], True)
    y = Axis([p[2] for c in curves.values() for p in c], MARGIN[1] + PANEL[1], MARGIN[1], False)
    bottom, top = MARGIN[1] + PANEL[1], MARGIN[1]
    out = [f'<rect x="{left}" y="{top}" width="{PANEL[0]}" height="{PANEL[1]}" fill="none" stroke="#333"/>']
    for v in x.ticks():
        out.append(f'<line x1="{x(v):.1f}" x2="{x(v):.1f}" y1="{top}" y2="{bottom}" stroke="#ddd"/>')
        out.append(f'<text x="{x(v):.1f}" y="{bottom + 16}" text-anchor="middle">{v:g}</text>')
    for v in y.ticks():
        out.append(f'<line x1="{left}" x2="{left + PANEL[0]}" y1="{y(v):.1f}" y2="{y(v):.1f}" stroke="#ddd"/>')
        out.append(f'<text x="{left - 6}" y="{y(v) + 4:.1f}" text-anchor="end">{v:g}</text>')
    out.append(f'<text x="{left + PANEL[0] / 2}" y="{bottom + 36}" text-anchor="middle">{label}</text>')
    for name, points in curves.items():
        colour = COLOURS.get(name, "#000")
        places = " ".join(f"{x(p[column]):.1f},{y(p[2]):.1f}" for p in points)
        out.append(f'<polyline points="{places}" fill="none" stroke="{colour}" stroke-width="2"/>')
        out += [f'<circle cx="{x(p[column]):.1f}" cy="{y(p[2]):.1f}" r="3" fill="{colour}"/>' for p in points]
    return out


def legend(curves, left):
    out = []
    for i, name in enumerate(curves):
        at = MARGIN[1] + 20 + 18 * i
        out.append(f'<line x1="{left}" x2="{left + 24}" y1="{at}" y2="{at}" stroke="{COLOURS.get(name, "#000")}" stroke-width="2"/>')
        out.append(f'<text x="{left + 30}" y="{at + 4}">{name}</text>')
    return out


def picture(curves):
    second = 2 * MARGIN[0] + PANEL[0]
    width, height = second + PANEL[0] + 20, PANEL[1] + 2 * MARGIN[1] + 10
    parts = panel(curves, 0, "samples per pixel", MARGIN[0])
    parts += panel(curves, 1, "seconds (256 x 256 pixels, one thread)", second)
    parts += legend(curves, MARGIN[0] + 14)
    parts.append(f'<text x="{MARGIN[0]}" y="24">Scene A, single scattering, stratified: PSNR in dB</text>')
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            f'font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="#fff"/>'
            + "\n".join(parts) + "</svg>\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("csv", help="written by bench_collimated --csv")
    parser.add_argument("svg", help="the plot")
    arguments = parser.parse_args()
    try:
        curves = read(arguments.csv)
    except (OSError, ValueError, KeyError) as error:
        print(f"collimated_plot.py: {error}", file=sys.stderr)
        return 1
    with open(arguments.svg, "w", encoding="utf-8") as file:
        file.write(picture(curves))
    return 0


if __name__ == "__main__":
    sys.exit(main())
