#!/usr/bin/env python3
"""Method ordinates beside volumetric path tracing: media under photographed skies, errors, times, and
contact sheets. Needs NumPy and Pillow, and the scenes made by others in ../shared.

    python3 bench/ordinates_figures.py --sheet docs/ordinates-modes.png
    python3 bench/ordinates_figures.py --directions docs/ordinates-directions.png

The first renders each scene at the interactive level by modes dom, cm, literal and shdom, and by
path. Printed are, of light that media scatter (M1 and M2): bias, relative to its mean by path; of
the picture: relMSE (docs/metrics.md) when those two terms are replaced by the mode's, less the
variance of the reference; seconds of processor time; and how many times longer path needs until its
own variance is as large as the mode's squared error. The sheet has the pictures and, below, what is
too much in red and too little in blue, full at a quarter of the mean.

The second renders one scene with 1, 4, 16, 64 and 256 directions, with and without prefilter,
importance and residuum, as figures 6 to 8, 14 and 15 of [Elek2014] do.
"""

import argparse
import os
import resource
import subprocess
import tempfile

import numpy as np
from PIL import Image, ImageDraw

import exr
import ordinates_scenes as scenes

MODES = ("dom", "cm", "literal", "shdom")
COUNTS = (1, 4, 16, 64, 256)
SWITCHES = {
    "all": ["--importance"],
    "no prefilter": ["--importance", "--no-prefilter"],
    "no importance": [],
    "no residuum": ["--importance", "--no-residuum"],
}
LABEL = 14


def run(options, scene, out, extra):
    """Renders; seconds of processor time."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [options.airlight, "render", scene, "-o", out, "-q", "--width", str(options.width)]
    subprocess.run(command + extra, check=True, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def colour(path, layer=""):
    return exr.colour(exr.read(path), layer)


def reference(options, name, scene):
    """Channels of path's picture and its seconds; kept from run to run."""
    out = os.path.join(options.cache, f"{name}-{options.width}-{options.spp}.exr")
    note = out + ".seconds"
    if not os.path.exists(note):
        extra = ["--method", "path", "--layers", "--variance", "--spp", str(options.spp)]
        seconds = run(options, scene, out, extra + ["--max-depth", "1000000"])
        with open(note, "w") as file:
            file.write(str(seconds))
    with open(note) as file:
        return exr.read(out), float(file.read())


def errors(media, channels, seconds, own_seconds):
    """Bias, relMSE and path's time for it over one's own."""
    whole, truth = exr.colour(channels), sum(exr.colour(channels, t) for t in ("M1", "M2"))
    variance = exr.colour(channels, "variance")
    scale = whole**2 + 1e-4 * whole.mean() ** 2
    noise = (variance / scale).mean()
    error = ((media - truth) ** 2 / scale).mean() - noise
    bias = media.mean() / truth.mean() - 1.0
    ratio = seconds * noise / max(error, 1e-9) / own_seconds
    return bias, error, noise, ratio


# ---- sheets ----


def tone(image, mean):
    scaled = np.clip(image * (0.18 / mean), 0.0, 1.0)
    return (scaled ** (1.0 / 2.2) * 255.0 + 0.5).astype(np.uint8)


def signed(difference, mean):
    share = np.clip(difference.mean(-1) / (0.25 * mean), -1.0, 1.0)
    red, blue = np.maximum(share, 0.0), np.maximum(-share, 0.0)
    picture = np.stack([1.0 - blue, 1.0 - red - blue, 1.0 - red], -1)
    return (np.clip(picture, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)


def sheet(rows, path):
    """rows: lists of (label, picture)."""
    high, wide = rows[0][0][1].shape[:2]
    out = Image.new("RGB", (wide * max(map(len, rows)), (high + LABEL) * len(rows)), "white")
    draw = ImageDraw.Draw(out)
    for j, row in enumerate(rows):
        for i, (label, picture) in enumerate(row):
            out.paste(Image.fromarray(picture), (i * wide, j * (high + LABEL) + LABEL))
            draw.text((i * wide + 2, j * (high + LABEL) + 1), label, fill="black")
    out.save(path)


# ---- the two tables ----


def compare_modes(options, found, folder):
    rows = []
    print(f"{'scene':16}{'mode':10}{'bias':>9}{'relMSE':>10}{'s':>8}{'path, times':>13}")
    for name, scene in found.items():
        channels, seconds = reference(options, name, scene)
        whole = exr.colour(channels)
        truth = exr.colour(channels, "M1") + exr.colour(channels, "M2")
        pictures = [(name + ", path", tone(whole, whole.mean()))]
        differences = [("difference", np.full(whole.shape, 255, np.uint8))]
        for mode in options.modes:
            out = os.path.join(folder, "mode.exr")
            extra = ["--quality", "interactive", "--method", "ordinates:" + mode]
            own = run(options, scene, out, extra + ["--terms", "M1,M2"])
            media = colour(out)
            bias, error, noise, ratio = errors(media, channels, seconds, own)
            print(f"{name:16}{mode:10}{bias:+9.2%}{error:10.2g}{own:8.2f}{ratio:13.0f}")
            pictures.append((mode, tone(whole + media - truth, whole.mean())))
            differences.append((f"{bias:+.1%}, {error:.1e}", signed(media - truth, whole.mean())))
        print(f"{name:16}{'path':10}{'':9}{noise:10.2g}{seconds:8.2f}")
        rows += [pictures, differences]
    if options.sheet:
        sheet(rows, options.sheet)


def compare_directions(options, scene, folder):
    rows = []
    channels, _ = reference(options, options.scene, scene)
    truth = exr.colour(channels, "M1") + exr.colour(channels, "M2")
    for label, switch in SWITCHES.items():
        for mode in ("cm",) if label == "no residuum" else ("dom", "cm"):
            row = []
            for count in COUNTS:
                out = os.path.join(folder, "count.exr")
                extra = ["--quality", "interactive", "--method", "ordinates:" + mode, *switch]
                run(options, scene, out, extra + ["--terms", "M1,M2", "--directions", str(count)])
                media = colour(out)
                error = np.sqrt(((media - truth) ** 2).mean()) / truth.mean()
                bias = media.mean() / truth.mean() - 1.0
                print(f"{mode:5}{label:15}{count:5} directions{bias:+8.2%}{error:9.3f}")
                row.append((f"{mode}, {label}, {count}", tone(media, truth.mean() * 4.0)))
            rows.append(row)
    sheet(rows, options.directions)


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--airlight", default=os.path.join(here, "../build/release/airlight"))
    parser.add_argument("--shared", default=os.path.join(here, "../../shared/scenes"), type=os.path.abspath)
    parser.add_argument("--width", type=int, default=160)
    parser.add_argument("--spp", type=int, default=512, help="of path")
    parser.add_argument("--cache", help="folder that keeps path's pictures")
    parser.add_argument("--modes", nargs="+", default=MODES)
    parser.add_argument("--only", nargs="+", help="of the scenes")
    parser.add_argument("--sheet", help="PNG of the modes")
    parser.add_argument("--directions", help="PNG of numbers of directions, of --scene alone")
    parser.add_argument("--scene", default="smoke-indoors")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        options.cache = options.cache or folder
        os.makedirs(options.cache, exist_ok=True)
        found = scenes.write_all(folder, options.shared, options.airlight)
        if options.directions:
            compare_directions(options, found[options.scene], folder)
        else:
            wanted = {n: s for n, s in found.items() if not options.only or n in options.only}
            compare_modes(options, wanted, folder)


if __name__ == "__main__":
    main()
