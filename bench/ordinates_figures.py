#!/usr/bin/env python3
"""Method ordinates beside volumetric path tracing: media under photographed skies, errors, times, and
contact sheets. Needs NumPy and Pillow, and the scenes made by others in ../shared.

    python3 bench/ordinates_figures.py --sheet docs/ordinates-modes.png
    python3 bench/ordinates_figures.py --directions docs/ordinates-directions.png

The first renders each scene at the interactive level by modes dom, cm, literal and shdom, and twice
by path. Printed are, of light that media scatter (M1 and M2): bias, relative to its mean by path; of
the picture: relMSE, the product of the differences to either of path's pictures, which have noise in
common with neither each other nor the mode, over the square of the picture with the mode's light
(rare bright samples of path would lower the weight of their own pixels); seconds of processor time;
and how many times longer path needs until its own variance is as large as the mode's squared error.
The sheet has the pictures and, below, what is too much in red and too little in blue, full at a
quarter of the mean.

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


class Reference:
    """Two pictures by path and the seconds that one took; kept from run to run."""

    def __init__(self, options, name, scene):
        pictures, self.seconds = [], 0.0
        for seed in (1, 2):
            out = os.path.join(options.cache, f"{name}-{options.width}-{options.spp}-{seed}.exr")
            note = out + ".seconds"
            if not os.path.exists(note):
                extra = ["--method", "path", "--layers", "--spp", str(options.spp)]
                extra += ["--seed", str(seed), "--max-depth", "1000000"]
                with open(note + ".part", "w") as file:
                    file.write(str(run(options, scene, out, extra)))
                os.rename(note + ".part", note)
            with open(note) as file:
                self.seconds += float(file.read()) / 2.0
            pictures.append(exr.read(out))
        self.media = [sum(exr.colour(p, t) for t in ("M1", "M2")) for p in pictures]
        self.truth = (self.media[0] + self.media[1]) / 2.0
        self.whole = (exr.colour(pictures[0]) + exr.colour(pictures[1])) / 2.0

    def errors(self, media, own_seconds):
        """Bias, relMSE, that of one of the two, and path's time for it over one's own."""
        whole = self.whole - self.truth + media
        scale = whole**2 + 1e-4 * whole.mean() ** 2
        noise = ((self.media[0] - self.media[1]) ** 2 / scale).mean() / 2.0
        error = ((media - self.media[0]) * (media - self.media[1]) / scale).mean()
        bias = media.mean() / self.truth.mean() - 1.0
        return bias, error, noise, self.seconds * noise / max(error, 1e-9) / own_seconds


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
        path = Reference(options, name, scene)
        whole, truth = path.whole, path.truth
        pictures = [(name + ", path", tone(whole, whole.mean()))]
        differences = [("difference", np.full(whole.shape, 255, np.uint8))]
        for mode in options.modes:
            out = os.path.join(folder, "mode.exr")
            extra = ["--quality", "interactive", "--method", "ordinates:" + mode]
            extra += ["--bands", str(options.bands)] if options.bands else []
            own = run(options, scene, out, extra + ["--terms", "M1,M2"])
            media = colour(out)
            bias, error, noise, ratio = path.errors(media, own)
            print(f"{name:16}{mode:10}{bias:+9.2%}{error:10.2g}{own:8.2f}{ratio:13.0f}")
            pictures.append((mode, tone(whole + media - truth, whole.mean())))
            differences.append((f"{bias:+.1%}, {error:.1e}", signed(media - truth, whole.mean())))
        print(f"{name:16}{'path':10}{'':9}{noise:10.2g}{path.seconds:8.2f}")
        rows += [pictures, differences]
    if options.sheet:
        sheet(rows, options.sheet)


def compare_directions(options, scene, folder):
    rows = []
    path = Reference(options, options.scene, scene)
    truth = path.truth
    for label, switch in SWITCHES.items():
        for mode in ("cm",) if label == "no residuum" else ("dom", "cm"):
            row = [(options.scene + ", path", tone(truth, truth.mean() * 4.0))]
            for count in COUNTS:
                out = os.path.join(folder, "count.exr")
                extra = ["--quality", "interactive", "--method", "ordinates:" + mode, *switch]
                run(options, scene, out, extra + ["--terms", "M1,M2", "--directions", str(count)])
                media = colour(out)
                square = ((media - path.media[0]) * (media - path.media[1])).mean()
                error = np.sqrt(max(square, 0.0)) / truth.mean()
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
    parser.add_argument("--spp", type=int, default=256, help="of each picture by path")
    parser.add_argument("--cache", help="folder that keeps path's pictures")
    parser.add_argument("--modes", nargs="+", default=MODES)
    parser.add_argument("--bands", type=int, help="for the level's")
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
