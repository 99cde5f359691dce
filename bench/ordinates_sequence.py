#!/usr/bin/env python3
"""How much sequences of method ordinates flicker, begun from the frame before and each from nothing.
Needs NumPy.

    python3 bench/ordinates_sequence.py

Blobs of cloud drift through a box of 1 m under the sky of scenes/smoke, 48^3 voxels a frame: in the
whole box; cut to the voxels that hold something, so that the medium's bounds move from frame to
frame; standing still while the camera turns, or moving as a whole. Each is rendered at the level interactive, warm
(the default) and cold (--no-warm-start), and converged, for the reference: the same method, cold,
with twice the cells, more directions, sweeps and looks. As many bands, for what these change is how
light depends on the angle, smoothly. Of the light that the media scatter, which is the method's: the
sky behind them is path's, with noise at few samples (--terms all has it). Printed are `airlight diff --temporal` against that (docs/metrics.md), the relative RMSE of
frames, the solver's sweeps per frame behind the first, and seconds per frame, all of it.
"""

import argparse
import json
import os
import re
import struct
import subprocess
import tempfile
import time

import numpy as np

import exr

SIDE = 48
HERE = os.path.dirname(os.path.abspath(__file__))
SKY = os.path.join(HERE, "..", "scenes", "smoke", "sky.hdr")
CONVERGED = "--cells 40 --directions 512 --sweeps 256 --march 4 --spp 32".split()


# ---- scenes ----


def blobs(time_s):
    """Density of balls that drift and turn, in a grid about the origin of edge 1; smooth in time."""
    rng = np.random.default_rng(5)
    axis = (np.arange(SIDE) + 0.5) / SIDE - 0.5
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    density = np.zeros((SIDE, SIDE, SIDE))
    for _ in range(24):
        centre = rng.uniform(-0.26, 0.26, 3) * (1.0, 0.7, 1.0)
        radius, phase = rng.uniform(0.07, 0.15), rng.uniform(0.0, 2.0 * np.pi)
        turn = 0.35 * time_s + phase
        moved = centre + (0.12 * time_s - 0.06, 0.03 * np.sin(turn), 0.04 * np.cos(turn))
        distance = np.sqrt((x - moved[0]) ** 2 + (y - moved[1]) ** 2 + (z - moved[2]) ** 2)
        density = np.maximum(density, np.clip(1.4 * (1.0 - distance / radius), 0.0, 1.0))
    return density


def write_volume(path, density, low, high):
    """Mitsuba's grid volume; density is indexed [z][y][x]."""
    depth, height, width = density.shape
    header = struct.pack("<3sB", b"VOL", 3) + struct.pack("<5i", 1, width, height, depth, 1)
    with open(path, "wb") as file:
        file.write(header + struct.pack("<6f", *low, *high) + density.astype("<f4").tobytes())


def write_cut(path, density):
    """Only the part that holds something."""
    low, high = [], []
    for axis in (2, 1, 0):
        others = tuple(a for a in range(3) if a != axis)
        filled = np.flatnonzero(density.max(others))
        low.append(filled[0])
        high.append(filled[-1] + 1)
    part = density[low[2] : high[2], low[1] : high[1], low[0] : high[0]]
    place = [[n / SIDE - 0.5 for n in corner] for corner in (low, high)]
    write_volume(path, part, *place)


def write_scene(folder, g, kind, frames):
    camera = {"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.01}}
    node = {"camera": 0, "translation": [0.0, 0.1, 2.0]}
    scene = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [node]}
    name = "still.vol" if kind == "orbit" else "blobs.####.vol"
    medium = {"sigma_s": [24, 24, 24], "sigma_a": [0.2, 0.3, 0.5], "g": g}
    medium["density"] = {"grid": {"file": name}}
    sky = {"name": "sky", "type": "environment", "image": os.path.abspath(SKY)}
    with open(os.path.join(folder, "scene.gltf"), "w") as file:
        json.dump({**scene, "cameras": [camera]}, file)
    with open(os.path.join(folder, "scene.airlight.json"), "w") as file:
        json.dump({"media": [medium], "lights": [sky]}, file)
    corner = (0.5, 0.5, 0.5)
    for frame in range(1, frames + 1):
        density = blobs((frame - 1) / 24.0)
        path = os.path.join(folder, f"blobs.{frame:04d}.vol")
        if kind == "cut":
            write_cut(path, density)
        elif kind == "box":
            write_volume(path, density, [-c for c in corner], corner)
        elif frame == 1:
            still = density
            write_volume(os.path.join(folder, "still.vol"), still, [-c for c in corner], corner)
        if kind == "whole":
            by = 0.011 * (frame - 1)
            write_volume(path, still, [by - c for c in corner], [by + c for c in corner])


# ---- measuring ----


def render(options, folder, out, kind, extra):
    command = [options.airlight, "render", os.path.join(folder, "scene.gltf"), "-v"]
    command += ["--quality", "interactive", "--method", "ordinates", "--progress", "none"]
    command += ["--width", str(options.width), "--height", str(options.width * 3 // 4)]
    command += ["--frames", f"1-{options.frames}", "-t", str(options.threads)]
    command += ["--orbit", "1.5"] if kind == "orbit" else []
    command += ["--terms", options.terms] if options.terms != "all" else []
    command += [*extra, "-o", os.path.join(folder, out + ".####.exr")]
    begin = time.monotonic()
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    seconds = (time.monotonic() - begin) / options.frames
    sweeps = [int(n) for n in re.findall(r"ordinates: (\d+) sweeps", done.stderr)]
    return seconds, np.mean(sweeps[1:])


def temporal(options, folder, a, b):
    paths = [os.path.join(folder, name + ".####.exr") for name in (a, b)]
    command = [options.airlight, "diff", "--temporal", *paths, "--frames", f"1-{options.frames}"]
    done = subprocess.run([*command, "--json"], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def frame_error(options, folder, a, b):
    """Root of the mean square difference over all frames, relative to the mean."""
    squares, mean = 0.0, 0.0
    for frame in range(1, options.frames + 1):
        images = [exr.read(os.path.join(folder, f"{n}.{frame:04d}.exr")) for n in (a, b)]
        pair = [exr.colour(image) for image in images]
        squares += ((pair[0] - pair[1]) ** 2).mean()
        mean += pair[1].mean()
    return np.sqrt(squares / options.frames) / (mean / options.frames)


def measure(options, folder, g, kind):
    write_scene(folder, g, kind, options.frames)
    render(options, folder, "truth", kind, ["--no-warm-start", *CONVERGED, "--seed", "7"])
    for name, extra in (("cold", ["--no-warm-start"]), ("warm", [])):
        seconds, sweeps = render(options, folder, name, kind, [*options.extra.split(), *extra])
        found = temporal(options, folder, name, "truth")
        error = frame_error(options, folder, name, "truth")
        print(
            f"{kind:<6} g {g:<5} {name:<5} {found['temporal-ratio']:7.3f} "
            f"{found['temporal-ratio-of-means']:9.3f} {found['temporal-difference']:11.2e} "
            f"{100 * error:7.2f} % {sweeps:7.1f} {seconds:8.2f}",
            flush=True,
        )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--airlight", default="build/release/airlight", metavar="PATH")
    parser.add_argument("--frames", type=int, default=24, metavar="N")
    parser.add_argument("--width", type=int, default=96, metavar="PIXELS")
    parser.add_argument("--threads", type=int, default=1, metavar="N")
    parser.add_argument("--kinds", default="box,cut,orbit,whole")
    parser.add_argument("--g", default="0.5,0.9")
    parser.add_argument("--terms", default="M1,M2")
    parser.add_argument("--extra", default="", help="options of warm and cold")
    parser.add_argument("--keep", metavar="DIR", help="keep the frames there")
    options = parser.parse_args()
    print(f"{'':<20} {'ratio':>7} {'of means':>9} {'difference':>11} {'error':>9} sweeps  seconds")
    for kind in options.kinds.split(","):
        for g in map(float, options.g.split(",")):
            with tempfile.TemporaryDirectory() as folder:
                if options.keep:
                    folder = os.path.join(options.keep, f"{kind}-{g}")
                    os.makedirs(folder, exist_ok=True)
                measure(options, folder, g, kind)


if __name__ == "__main__":
    main()
