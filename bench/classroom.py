#!/usr/bin/env python3
"""Bitterli's classroom ("Japanese Classroom" by NovaZeeke, CC BY 3.0), filled with haze: sun and sky
through real windows. Needs ../shared/scenes, NumPy and Pillow.

    python3 bench/classroom.py --picture docs/classroom.png
    python3 bench/classroom.py --compare 60

--picture renders the room with its layers, smooths those that are all noise (S+ and M2), and writes
it behind the view transform.

--compare renders it for so many seconds by `auto`, by `sky=ordinates` and by `path` in turn, and
prints of the picture and of each layer the bias and the relMSE (docs/metrics.md) against `path` with
--reference-spp samples, whose own noise it tells too: the relMSE that the true picture would have.
"""

import argparse
import json
import os
import subprocess
import tempfile

import numpy as np
from PIL import Image

import exr
from truth import relative

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
SCENE = os.path.join(ROOT, "..", "shared", "scenes", "bitterli_classroom", "scene.xml")
HAZE = "box=-4.4,0,-5.98:4,3.05,5.98,sigma_s=0.05,g=0.3"  # from wall to wall
METHODS = ("auto", "sky=ordinates", "path")
LAYERS = ("", "S0", "S+", "M1", "M2", "background")


def run(options, *arguments):
    command = [options.airlight, *arguments, "-q", "-t", str(options.threads)]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def render(options, out, *arguments):
    """What `render --json` says of the room's picture."""
    common = ("render", SCENE, "--medium", HAZE, "--layers", "--json", "-o", out)
    return json.loads(run(options, *common, *arguments))


def draw(options, folder):
    raw, smooth = os.path.join(folder, "raw.exr"), os.path.join(folder, "smooth.png")
    size = ("--width", str(options.width), "--height", str(options.width * 9 // 16))
    render(options, raw, *size, "--spp", str(options.spp), "--guides")
    shown = ("--exposure", options.exposure)
    run(options, "denoise", raw, smooth, "--terms", "S+,M2", "--levels", "4", *shown)
    image = Image.open(smooth).convert("RGB")
    image.save(options.picture, optimize=True)
    size = os.path.getsize(options.picture)
    print(f"{options.picture}: {image.width} x {image.height}, {size} bytes", flush=True)


def compare(options, folder):
    def at(name):
        return os.path.join(folder, name + ".exr")

    size = ("--width", "240", "--height", "135")
    truth = options.reference
    if truth is None:
        truth = at("reference")
        spp = ("--spp", str(options.reference_spp))
        render(options, truth, *size, "--method", "path", *spp, "--seed", "9", "--variance")
    truth = exr.read(truth)
    mean = exr.colour(truth)
    noise = relative(exr.colour(truth, "variance"), mean)
    print(f"the reference's own noise: {noise:.4f}")
    print(f"{'':16}{'spp':>6}{'seconds':>9}  layer       bias, %    relMSE")
    for name in METHODS:
        time = ("--time", str(options.compare))
        said = render(options, at(name), *size, "--method", name, *time)
        found = exr.read(at(name))
        first = f"{name:16}{said['samples'][1]:6}{said['seconds']['render']:9.1f}"
        for layer in LAYERS:
            a, b = exr.colour(found, layer), exr.colour(truth, layer)
            bias = 100.0 * (a.mean() / b.mean() - 1.0)
            print(f"{first:31}  {layer or 'all':10}{bias:9.2f}{relative((a - b) ** 2, b):10.4f}", flush=True)
            first = ""


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--airlight", default="build/release/airlight", metavar="PATH")
    parser.add_argument("--picture", metavar="PNG")
    parser.add_argument("--width", type=int, default=960, metavar="N")
    parser.add_argument("--spp", type=int, default=64, metavar="N")
    parser.add_argument("--exposure", default="0", metavar="STOPS")
    parser.add_argument("--compare", type=float, metavar="SECONDS")
    parser.add_argument("--reference", metavar="EXR", help="one that was made before")
    parser.add_argument("--reference-spp", type=int, default=1024, metavar="N")
    parser.add_argument("--threads", type=int, default=2, metavar="N")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if options.picture is not None:
            draw(options, folder)
        if options.compare is not None:
            compare(options, folder)


if __name__ == "__main__":
    main()
