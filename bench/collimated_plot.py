#!/usr/bin/env python3
"""Error of the collimated estimators over samples and over seconds, as one SVG file.

    build/release/bench_collimated --csv collimated.csv
    bench/collimated_plot.py collimated.csv collimated.svg
"""
import argparse
import csv
import sys

import plot

COLOURS = {"RM": "#7f7f7f", "DS": "#1f77b4", "REES": "#2ca02c", "REDS": "#d62728", "WVDS": "#9467bd"}


def read(path, column):
    """{estimator: [(column, psnr)]}, in the order of the file."""
    curves = {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            curves.setdefault(row["estimator"], []).append((float(row[column]), float(row["psnr_db"])))
    if not curves:
        raise ValueError(f"{path}: no rows")
    return curves


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("csv", help="written by bench_collimated --csv")
    parser.add_argument("svg", help="the plot")
    arguments = parser.parse_args()
    try:
        panels = [plot.panel(read(arguments.csv, column), COLOURS, plot.place(i), label)
                  for i, (column, label) in enumerate([
                      ("samples", "samples per pixel"), ("seconds", "seconds (256 x 256 pixels, one thread)")])]
    except (OSError, ValueError, KeyError) as error:
        print(f"collimated_plot.py: {error}", file=sys.stderr)
        return 1
    with open(arguments.svg, "w", encoding="utf-8") as file:
        file.write(plot.document(panels, COLOURS, "Scene A, single scattering, stratified: PSNR in dB"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
