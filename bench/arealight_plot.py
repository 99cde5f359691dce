#!/usr/bin/env python3
"""Error of the ways to integrate a lamp's light in haze over time, as one SVG file.

    build/release/bench_arealight --csv arealight.csv
    bench/arealight_plot.py arealight.csv arealight.svg
"""
import argparse
import csv
import sys

import plot

PALETTE = ["#7f7f7f", "#8c564b", "#2ca02c", "#bcbd22", "#17becf", "#1f77b4", "#9467bd", "#d62728"]


def read(path):
    """{setting: {method: [(microseconds, relmse)]}}, in the order of the file."""
    settings = {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            setting = f"g = {row['g']}, sigma_s = {row['sigma_s']} / m"
            settings.setdefault(setting, {}).setdefault(row["method"], []).append(
                (float(row["us_per_pixel"]), float(row["relmse"])))
    if not settings:
        raise ValueError(f"{path}: no rows")
    return settings


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("csv", help="written by bench_arealight --csv")
    parser.add_argument("svg", help="the plot")
    arguments = parser.parse_args()
    try:
        settings = read(arguments.csv)
    except (OSError, ValueError, KeyError) as error:
        print(f"arealight_plot.py: {error}", file=sys.stderr)
        return 1
    names = list(next(iter(settings.values())))
    colours = dict(zip(names, PALETTE))
    panels = [plot.panel(curves, colours, plot.place(i), "microseconds per pixel, one thread", setting, True)
              for i, (setting, curves) in enumerate(settings.items())]
    with open(arguments.svg, "w", encoding="utf-8") as file:
        file.write(plot.document(panels, colours, "Scene A of the arealight method: relMSE"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
