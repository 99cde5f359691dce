#!/usr/bin/env python3
"""Peak memory of a bake that fills one page: a square floor under a lamp in a box of haze, one
sample a texel, for each mode, and with --directional. Given scenes are baked as they are instead.

    python3 bench/bake_memory.py --page-size 4096
    python3 bench/bake_memory.py --page-size 4096 --texels-per-metre 40 room.glb

Peaks are those that the system keeps of a process (ru_maxrss, Linux and its unit of 1024 bytes).
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenes"))
from gltf_builder import Builder, write_json  # noqa: E402
from shapes import Shape  # noqa: E402

SIDE = 4.0  # metres of the floor


def floor_scene(folder):
    builder = Builder("floor")
    floor = Shape(builder.material("grey", (0.6, 0.6, 0.6), specular=0.0))
    h = SIDE / 2.0
    floor.face(((-h, 0, h), (h, 0, h), (h, 0, -h), (-h, 0, -h)))
    builder.mesh("floor", floor)
    builder.camera("camera", (0.0, 4.0, 4.0), (0.0, 0.0, 0.0), math.radians(50.0), 1.0)
    builder.write(folder, "floor")
    haze = {"min": [-h, 0.0, -h], "max": [h, 2.0, h]}
    sidecar = {
        "media": [{"name": "haze", "sigma_s": 0.3, "boundary": {"box": haze}}],
        "lights": [{"type": "point", "position": [0.0, 1.5, 0.0], "intensity": 10.0}],
    }
    write_json(os.path.join(folder, "floor.airlight.json"), sidecar)
    return os.path.join(folder, "floor.gltf")


def run(command):
    """Runs it; its peak in bytes."""
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"bake_memory: {' '.join(command)}: exit code {process.returncode}")
    return 1024 * usage.ru_maxrss


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene", nargs="?", help="default: the floor")
    parser.add_argument("--airlight", default="build/release/airlight", metavar="PATH")
    parser.add_argument("--page-size", type=int, default=4096, metavar="N")
    parser.add_argument("--texels-per-metre", type=float, metavar="D")
    parser.add_argument("--modes", nargs="+", default=["none", "exact", "exact --directional"])
    parser.add_argument("--threads", type=int, default=1, metavar="N")
    options = parser.parse_args()
    density = options.texels_per_metre
    if density is None:  # padding lies about the floor, too
        density = (options.page_size - 16) / SIDE
    with tempfile.TemporaryDirectory() as folder:
        scene = options.scene or floor_scene(folder)
        out = os.path.join(folder, "lightmap")
        for mode in options.modes:
            command = [options.airlight, "bake", scene, "-o", out, "-q", "--spp", "1"]
            command += ["-t", str(options.threads), "--page-size", str(options.page_size)]
            command += ["--texels-per-metre", str(density), "--media", *mode.split()]
            peak = run(command + ["--no-resume"])
            with open(os.path.join(out, "lightmap.json"), encoding="utf-8") as file:
                pages = json.load(file)["pages"]
            texels = sum(page["width"] * page["height"] for page in pages)
            sizes = ", ".join(f"{page['width']} x {page['height']}" for page in pages)
            print(f"{mode}: {sizes}: {peak / 1e9:.2f} GB, {peak / texels:.0f} bytes a texel")


if __name__ == "__main__":
    main()
