#!/usr/bin/env python3
"""A surface bake that another baker was measured on: house.glb on its own TEXCOORD_1, all of it grey
Lambert, a sun and an even sky. Needs NumPy, and the scene (playcanvas/engine, house.glb), which is
not the project's and not in it.

    python3 bench/bake_anchor.py ../shared/scenes/gltf_playcanvas/house.glb

Printed are millions of texel samples per second of processor time on one thread, the means of
irradiance / pi over all covered texels and over those covered at least half, and the noise (half the
mean square difference of two seeds, its root over the mean), by mesh; then the same in haze that
fills the scene, by mode, with the time over that of attenuate. Blender 3.4.1, Cycles: 0.245 million,
means 0.50025 and 0.27899 with 256 samples, noise 0.039 and 0.056 with 64, +116 to +136 % for a
medium.
"""

import argparse
import json
import os
import resource
import subprocess
import tempfile

import numpy as np

import exr
import glb

LIGHTS = [
    {"type": "collimated", "direction": [-0.35355, -0.70711, -0.61237], "irradiance": [3, 3, 3]},
    {"type": "environment", "radiance": [0.5, 0.5, 0.5]},
]
HAZE = {
    "sigma_s": 1.0,
    "g": 0.3,
    "boundary": {"box": {"min": [-0.4, -0.01, -0.4], "max": [0.4, 0.4, 0.4]}},
}


def write_scene(source, folder, media):
    scene, rest = glb.read(source)
    grey = {"baseColorFactor": [0.60383] * 3 + [1], "metallicFactor": 0, "roughnessFactor": 1}
    for material in scene["materials"]:
        material.clear()
        material["doubleSided"] = True
        material["pbrMetallicRoughness"] = grey
        material["extensions"] = {"KHR_materials_specular": {"specularFactor": 0}}
    scene.setdefault("extensionsUsed", []).append("KHR_materials_specular")
    path = os.path.join(folder, "house.glb")
    glb.write(path, scene, rest)
    with open(os.path.join(folder, "house.airlight.json"), "w", encoding="utf-8") as file:
        json.dump({"lights": LIGHTS, "media": media}, file)
    return path


def bake(options, scene, out, seed, *more):
    """Seconds of processor time of one bake."""
    size = str(options.size)
    command = [options.airlight, "bake", scene, "-o", out, "-q", "-t", "1", "--seed", str(seed)]
    command += ["--uv", "file", "--mesh-size", size, "--page-size", size, "--padding", "0"]
    command += ["--spp", str(options.spp), *more]
    if options.bounces is not None:
        command += ["--bounces", str(options.bounces)]
    command += ["--no-denoise", "--no-stitch", "--dilate", "0", "--full", "--no-resume"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def pages(folder):
    for page in (0, 1):
        channels = exr.read(os.path.join(folder, f"page-{page}.exr"))
        light = exr.colour(channels).mean(axis=2) / np.pi
        yield light.astype(float), channels["coverage.Y"]


def report(folders, seconds, options, over=None):
    texels = sum(int((area > 0).sum()) for _, area in pages(folders[0]))
    rate = texels * options.spp / min(seconds) / 1e6
    text = f"{rate:.3f} M samples/s"
    if over is not None:
        text += f", {100 * (min(seconds) / over - 1):+.0f} % over attenuate"
    for (a, area), (b, _) in zip(pages(folders[0]), pages(folders[1])):
        covered, half = area > 0, area >= 0.5
        both = 0.5 * (a + b)
        noise = np.sqrt(0.5 * np.mean((a - b)[covered] ** 2)) / both[covered].mean()
        text += f"; {both[covered].mean():.4f} ({both[half].mean():.4f}), noise {noise:.4f}"
    return text


def run(options, scene, name, over, *more):
    folders = [scene + f".{seed}" for seed in (1, 2)]
    seconds = [bake(options, scene, folders[seed], seed + 1, *more) for seed in (0, 1)]
    print(f"{name:18} {report(folders, seconds, options, over)}", flush=True)
    return min(seconds)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene")
    parser.add_argument("--airlight", default="build/release/airlight")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--bounces", type=int, help="default: as many as it takes")
    parser.add_argument("--clear-only", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        scene = write_scene(options.scene, folder, [])
        run(options, scene, "clear", None)
        run(options, scene, "clear, whole paths", None, "--no-final-gather")
        if options.clear_only:
            return
        scene = write_scene(options.scene, folder, [HAZE])
        over = run(options, scene, "attenuate", None, "--media", "attenuate")
        for mode in ("none", "impulse", "exact"):
            run(options, scene, mode, over, "--media", mode)


if __name__ == "__main__":
    main()
