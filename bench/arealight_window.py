#!/usr/bin/env python3
"""A barred window in a hazy room: arealight with few shadow samples, path and Volume-RIS against path.

    bench/arealight_window.py build/release/airlight [--reference-spp 1024] [--keep FOLDER]

Prints seconds and relMSE of each; with --keep the pictures stay in FOLDER.
"""
import argparse
import base64
import json
import os
import re
import struct
import subprocess
import sys
import tempfile
import time

SIZE = ["--width", "320", "--height", "240", "--filter", "point", "--max-depth", "1", "-q"]

QUADS = [
    [(-3, 0, -2.5), (3, 0, -2.5), (3, 0, 2.5), (-3, 0, 2.5)],      # floor
    [(-3, 3, -2.5), (3, 3, -2.5), (3, 3, 2.5), (-3, 3, 2.5)],      # ceiling
    [(-3, 0, -2.5), (3, 0, -2.5), (3, 3, -2.5), (-3, 3, -2.5)],    # back
    [(3, 0, -2.5), (3, 0, 2.5), (3, 3, 2.5), (3, 3, -2.5)],        # right
    [(-2.8, 1.55, -1.1), (-2.8, 1.55, 1.1), (-2.8, 1.65, 1.1), (-2.8, 1.65, -1.1)],
    [(-0.5, 0.8, -1.2), (0.8, 0.8, -1.2), (0.8, 0.8, 0.2), (-0.5, 0.8, 0.2)],  # table
] + [[(-2.8, 0.8, z - 0.06), (-2.8, 0.8, z + 0.06), (-2.8, 2.4, z + 0.06), (-2.8, 2.4, z - 0.06)]
     for z in (-0.9, -0.45, 0.0, 0.45, 0.9)]

SIDECAR = {
    "lights": [{"name": "window", "type": "polygon", "radiance": [10, 11, 13], "camera_visible": False,
                "vertices": [(-2.95, 0.9, -1), (-2.95, 2.3, -1), (-2.95, 2.3, 1), (-2.95, 0.9, 1)]}],
    "media": [{"name": "haze", "sigma_s": 0.15, "sigma_a": 0.01, "g": 0.5,
               "boundary": {"box": {"min": [-3.01, -0.01, -2.51], "max": [3.01, 3.01, 2.51]}}}],
    "camera": {"position": [1.5, 1.5, 6.5], "look_at": [-0.6, 1.3, 0], "fov_y_degrees": 45},
}


def write_scene(folder):
    positions = b"".join(struct.pack("<3f", *v) for q in QUADS for v in q)
    indices = b"".join(struct.pack("<6I", *(4 * i + k for k in (0, 1, 2, 0, 2, 3))) for i in range(len(QUADS)))
    corners = [v for q in QUADS for v in q]
    data = base64.b64encode(positions + indices).decode()
    scene = {
        "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_materials_specular"],
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": "room", "mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"doubleSided": True, "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
                       "pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.6, 0.6, 1], "metallicFactor": 0}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(corners), "type": "VEC3",
             "min": [min(v[k] for v in corners) for k in range(3)],
             "max": [max(v[k] for v in corners) for k in range(3)]},
            {"bufferView": 1, "componentType": 5125, "count": 6 * len(QUADS), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(positions)},
                        {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
        "buffers": [{"byteLength": len(positions + indices),
                     "uri": "data:application/octet-stream;base64," + data}],
    }
    with open(os.path.join(folder, "window.gltf"), "w", encoding="utf-8") as file:
        json.dump(scene, file)
    with open(os.path.join(folder, "window.airlight.json"), "w", encoding="utf-8") as file:
        json.dump(SIDECAR, file)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("airlight")
    parser.add_argument("--reference-spp", type=int, default=1024)
    parser.add_argument("--keep")
    arguments = parser.parse_args()
    folder = arguments.keep or tempfile.mkdtemp()
    os.makedirs(folder, exist_ok=True)
    write_scene(folder)
    at = lambda name: os.path.join(folder, name + ".exr")

    def render(name, *options):
        start = time.monotonic()
        subprocess.run([arguments.airlight, "render", os.path.join(folder, "window.gltf"), *SIZE, "-o", at(name),
                        *options], check=True)
        return time.monotonic() - start

    def error(name):
        text = subprocess.run([arguments.airlight, "diff", at(name), at("reference")], check=True,
                              capture_output=True, text=True).stdout
        return float(re.search(r"rel-mse\s+(\S+)", text).group(1))

    seconds = render("reference", "--method", "path", "--spp", str(arguments.reference_spp), "--seed", "9")
    print(f"reference: path, {arguments.reference_spp} samples, {seconds:.0f} s")
    for k in (1, 2, 4, 16, 64):
        seconds = render(f"edge{k}", "--method", "arealight", "--spp", "1", "--shadow-samples", str(k))
        print(f"arealight, {k:2d} shadow samples     {seconds:6.2f} s  relMSE {error(f'edge{k}'):.2e}")
    for spp in (8, 16, 32):
        seconds = render(f"path{spp}", "--method", "path", "--spp", str(spp))
        print(f"path, {spp:2d} samples               {seconds:6.2f} s  relMSE {error(f'path{spp}'):.2e}")
    seconds = render("ris", "--method", "arealight:volume-ris", "--candidates", "32", "--spp", "2", "--guides")
    print(f"Volume-RIS, 32 candidates x 2  {seconds:6.2f} s  relMSE {error('ris'):.2e}")
    subprocess.run([arguments.airlight, "denoise", "-q", at("ris"), at("smooth")], check=True)
    print(f"the same, denoised                       relMSE {error('smooth'):.2e}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
