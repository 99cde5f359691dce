#!/usr/bin/env python3
"""Bevy's Cornell box baked without fog, beside the lightmaps that another baker made for it. Needs
NumPy and Pillow, and the scene and its lightmaps (bevyengine/bevy, assets/models/CornellBox and
assets/lightmaps), which are not the project's and not in it.

    python3 bench/cornell_lightmaps.py ../shared/scenes/bevy --sheet cornell.png

The lightmaps hold E / pi behind the curve of sRGB, stored as if it were linear: --stored compares
with the numbers as they are. --lambert takes the scene's specular reflection away (0.04 at normal
incidence, which glTF's materials have and that baker seems to have left out), --bounces may be
given several times. Counted are texels that are covered whole, that both have finite, that have any
light in ours (under the boxes there is none), and below 20 W/(m^2 sr) in ours, which leaves out the
ceiling 0.9 units above the lamp. The sheet: theirs, ours, the difference times 4.
"""

import argparse
import json
import os
import subprocess
import tempfile

import numpy as np
from PIL import Image, ImageDraw

import exr
import glb

THEIRS = 1024  # texels along a side
LABEL = 14
MESHES = [  # lightmap, (primitive of the mesh, what it is)
    ("Large", "large.box", [(0, "large box")]),
    ("Small", "small.box", [(0, "small box")]),
    ("Box", "cornell.box", [(0, "floor, ceiling, back"), (1, "red wall"), (2, "green wall")]),
]


def decode_srgb(x):
    return np.where(x < 0.04045, x / 12.92, ((np.maximum(x, 0.0) + 0.055) / 1.055) ** 2.4)


def encode_srgb(x):
    return np.where(x < 0.0031308, x * 12.92, 1.055 * np.maximum(x, 0.0031308) ** (1 / 2.4) - 0.055)


def without_specular(source, path):
    """A copy of a GLB whose materials are pure Lambert."""
    scene, rest = glb.read(source)
    for material in scene["materials"]:
        extensions = material.setdefault("extensions", {})
        extensions["KHR_materials_specular"] = {"specularFactor": 0.0}
    scene["extensionsUsed"].append("KHR_materials_specular")
    glb.write(path, scene, rest)


def read_theirs(options, folder):
    """Their lightmaps by name, at the size asked for; decoded before they are averaged."""
    found, factor = {}, THEIRS // options.size
    for name, _, _ in MESHES:
        source = os.path.join(options.scenes, "lightmaps", f"CornellBox-{name}.zstd.ktx2")
        path = os.path.join(folder, name + ".exr")
        subprocess.run([options.airlight, "convert", "-q", source, path], check=True)
        with np.errstate(invalid="ignore"):
            stored = exr.colour(exr.read(path))
            light = stored if options.stored else decode_srgb(stored)
            shape = (options.size, factor, options.size, factor, 3)
            found[name] = light.reshape(shape).mean((1, 3))
    return found


def bake(options, scene, bounces, folder):
    """{(mesh, primitive): page}, each mesh on a page of its own."""
    out = os.path.join(folder, "lightmap")
    command = [options.airlight, "bake", scene, "-o", out, "-q", "-t", str(options.threads)]
    command += ["--media", "none", "--uv", "file", "--padding", "0", "--dilate", "0", "--full"]
    command += ["--mesh-size", str(options.size), "--page-size", str(options.size)]
    command += ["--no-stitch", "--spp", str(options.spp), "--no-resume"]
    if bounces != "all":
        command += ["--bounces", bounces]
    subprocess.run(command, check=True)
    with open(os.path.join(out, "lightmap.json"), encoding="utf-8") as file:
        meshes = json.load(file)["meshes"]
    return {
        (m["name"], m["primitive"]): exr.read(os.path.join(out, f"page-{m['page']}.exr"))
        for m in meshes
    }


def counted(page, theirs):
    ours = exr.colour(page) / np.pi
    finite = np.isfinite(theirs).all(-1) & (np.abs(theirs) < 100.0).all(-1)
    lit = (ours.max(-1) > 1e-3) & (ours.max(-1) < 20.0)
    return (page["coverage.Y"] > 0.999) & finite & lit, ours


def compare(pages, theirs):
    for name, mesh, parts in MESHES:
        for primitive, title in parts:
            mask, ours = counted(pages[(mesh, primitive)], theirs[name])
            a, b = ours[mask], theirs[name][mask]
            off = 100.0 * (a.mean(0) / b.mean(0) - 1.0)
            rms = 100.0 * np.sqrt(((a - b) ** 2).mean()) / b.mean()
            print(
                "  %-21s %8d   %6.3f %6.3f %6.3f   %6.3f %6.3f %6.3f   %+6.1f %+6.1f %+6.1f %%"
                "   %5.1f %%" % (title, mask.sum(), *b.mean(0), *a.mean(0), *off, rms)
            )


def picture(light, size):
    bytes_ = np.round(255.0 * np.clip(encode_srgb(np.clip(light, 0.0, None)), 0.0, 1.0))
    return Image.fromarray(bytes_.astype(np.uint8)).resize((size, size), Image.BOX)


def draw_sheet(path, pages, theirs, size=300):
    sheet = Image.new("RGB", (3 * size, 3 * (size + LABEL)), "white")
    draw = ImageDraw.Draw(sheet)
    for row, (name, mesh, parts) in enumerate(MESHES):
        b = np.nan_to_num(theirs[name], nan=0.0, posinf=0.0, neginf=0.0)
        a, shown = np.zeros_like(b), np.zeros(b.shape[:2], bool)
        for primitive, _ in parts:
            page = pages[(mesh, primitive)]
            covered = page["coverage.Y"] > 0.0
            a[covered] = exr.colour(page)[covered] / np.pi
            shown |= counted(page, theirs[name])[0]
        images = (("theirs / 3", b / 3), ("ours / 3", a / 3))
        images += (("|ours - theirs| x 4 / 3", np.abs(a - b) * shown[..., None] * 4 / 3),)
        for column, (text, light) in enumerate(images):
            x, y = column * size, row * (size + LABEL)
            draw.text((x + 4, y + 1), name + ": " + text, fill="black")
            sheet.paste(picture(light, size), (x, y + LABEL))
    sheet.save(path)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scenes", help="the folder with CornellBox and lightmaps in it")
    parser.add_argument("--airlight", default="build/release/airlight", metavar="PATH")
    parser.add_argument("--size", type=int, default=256, help="texels a side, 1024 / 2^n")
    parser.add_argument("--spp", type=int, default=64, metavar="N")
    parser.add_argument("--threads", type=int, default=1, metavar="N")
    parser.add_argument("--bounces", action="append", metavar="N|all", help="default: all")
    parser.add_argument("--lambert", action="store_true")
    parser.add_argument("--stored", action="store_true")
    parser.add_argument("--sheet", metavar="PNG", help="of the last of the bounces")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        theirs = read_theirs(options, folder)
        scene = os.path.join(options.scenes, "CornellBox", "CornellBox.glb")
        if options.lambert:
            without_specular(scene, os.path.join(folder, "lambert.glb"))
            scene = os.path.join(folder, "lambert.glb")
        for bounces in options.bounces or ["all"]:
            pages = bake(options, scene, bounces, folder)
            print(f"bounces: {bounces}; {'Lambert' if options.lambert else 'the materials'}")
            print("  surface                 texels   theirs                 ours", end="")
            print("                   difference of means         rms")
            compare(pages, theirs)
        if options.sheet:
            draw_sheet(options.sheet, pages, theirs)


if __name__ == "__main__":
    main()
