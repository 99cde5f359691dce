#!/usr/bin/env python3
"""Contact sheets of the shipped room sunroom, baked. Needs NumPy and Pillow.

    python3 bench/bake_pictures.py --folder docs

baked-page.png: the page, its three layers and its coverage; white is covered whole. Layers are
brighter than the sum by the stops said.

baked-modes.png: the surfaces by the lightmaps of --media none, attenuate and exact, and by the
layer `media` of exact alone; fog between surface and eye takes light away and adds none.

baked-room.png: the room by `path` and by its lightmap, fog between surface and eye included, and
the layer `media` again. The first two are rendered twice as large and reduced behind the view
transform.

The ground and the trees outside, which would take nine tenths of all texels, are left out. Pictures
of one sheet have one exposure and view, but for the layer `media`, where it says so.
"""

import argparse
import json
import os
import shutil
import subprocess
import tempfile

import numpy as np
from PIL import Image, ImageDraw

import exr
from lightmap_folder import only_media, page_paths

MODES = ("none", "attenuate", "exact")
OUTSIDE = ("ground", "trees")
SURFACES = ("--terms", "S0,S+")
LABEL = 14


def room_without_outside(root, folder):
    source = os.path.join(root, "scenes", "sunroom")
    for name in os.listdir(source):
        if name.endswith((".png", ".bin", ".airlight.json")):
            shutil.copy(os.path.join(source, name), folder)
    with open(os.path.join(source, "sunroom.gltf"), encoding="utf-8") as file:
        gltf = json.load(file)
    outside = [i for i, node in enumerate(gltf["nodes"]) if node.get("name") in OUTSIDE]
    scene = gltf["scenes"][0]
    scene["nodes"] = [node for node in scene["nodes"] if node not in outside]
    path = os.path.join(folder, "sunroom.gltf")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(gltf, file)
    return path


def run(options, *arguments):
    command = [options.airlight, *arguments, "-q", "-t", str(options.threads)]
    subprocess.run(command, check=True)


def bake(options, scene, folder, mode):
    out = os.path.join(folder, mode + ".lightmap")
    texels = ["--texels-per-metre", str(options.texels), "--spp", str(options.spp)]
    run(options, "bake", scene, "-o", out, "--media", mode, *texels, "--full")
    return out


def render(options, scene, name, width, *arguments):
    out = os.path.join(os.path.dirname(scene), name + ".exr")
    size = ["--width", str(width), "--spp", str(options.picture_spp)]
    run(options, "render", scene, "-o", out, *size, *arguments)
    return out


def shown(options, path, exposure):
    """The picture behind the command's exposure and view."""
    out = path.replace(".exr", ".png")
    run(options, "convert", path, out, "--exposure", f"{exposure:.3f}")
    return Image.open(out).convert("RGB")


def automatic(path, share):
    """Stops that take the mean of the colours to a share of white."""
    return float(np.log2(share / exr.colour(exr.read(path)).mean()))


def sheet_of(tiles, columns):
    width, height = tiles[0][1].size
    rows = (len(tiles) + columns - 1) // columns
    sheet = Image.new("RGB", (columns * width, rows * (height + LABEL)), "white")
    draw = ImageDraw.Draw(sheet)
    for i, (text, image) in enumerate(tiles):
        at = (i % columns * width, i // columns * (height + LABEL))
        draw.text((at[0] + 3, at[1] + 1), text, fill="black")
        sheet.paste(image, (at[0], at[1] + LABEL))
    return sheet


def save(sheet, options, name):
    path = os.path.join(options.folder, name)
    sheet.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)
    print(f"{path}: {sheet.width} x {sheet.height}, {os.path.getsize(path)} bytes", flush=True)


def stops(text, more):
    return f"{text}, {more:+.1f} stops" if abs(more) >= 0.05 else text


def draw_room(options, folder):
    scene = room_without_outside(options.root, folder)
    lightmaps = {mode: bake(options, scene, folder, mode) for mode in MODES}
    draw_page(options, folder, lightmaps["exact"])
    lightmaps["media"] = os.path.join(folder, "media.lightmap")
    only_media(lightmaps["exact"], lightmaps["media"])
    surfaces = {
        mode: render(options, scene, mode, options.pixels, "--lightmap", lightmaps[mode], *SURFACES)
        for mode in lightmaps
    }
    exposure = automatic(surfaces["exact"], 0.25)
    more = round(automatic(surfaces["media"], 0.25) - exposure, 1)
    tiles = [(mode, shown(options, surfaces[mode], exposure)) for mode in MODES]
    alone = shown(options, surfaces["media"], exposure + more)
    tiles.append((stops("layer media alone", more), alone))
    save(sheet_of(tiles, 2), options, "baked-modes.png")
    wide = 2 * options.pixels
    whole = {
        "path": render(options, scene, "path", wide),
        "lightmap": render(options, scene, "baked", wide, "--lightmap", lightmaps["exact"]),
    }
    size = tiles[0][1].size
    exposure = automatic(whole["path"], 0.25)
    first = [
        (name, shown(options, path, exposure).resize(size, Image.Resampling.BOX))
        for name, path in whole.items()
    ]
    save(sheet_of([*first, tiles[-1]], 3), options, "baked-room.png")


def draw_page(options, folder, lightmap):
    page = exr.read(page_paths(lightmap)[0])
    height, width = page["R"].shape
    covered = page["coverage.Y"] > 0.0
    size = (options.page_pixels, round(options.page_pixels * height / width))
    tiles, base = [], None
    for text, layer in (("sum", ""), ("direct",) * 2, ("indirect",) * 2, ("media",) * 2):
        light = exr.colour(page, layer)
        exposure = float(np.log2(0.8 / np.percentile(light[covered].mean(-1), 90.0)))
        base = exposure if base is None else base
        more = round(max(exposure - base, 0.0), 1)
        path = os.path.join(folder, "layer-" + text + ".exr")
        exr.write(path, dict(zip("RGB", np.moveaxis(light, -1, 0))))
        image = shown(options, path, base + more).resize(size, Image.Resampling.BOX)
        tiles.append((stops(text, more), image))
    grey = Image.fromarray(np.round(255.0 * np.clip(page["coverage.Y"], 0, 1)).astype(np.uint8))
    tiles.append(("coverage", grey.convert("RGB").resize(size, Image.Resampling.BOX)))
    save(sheet_of(tiles, 3), options, "baked-page.png")
    print(f"page: {width} x {height}, {100 * covered.mean():.0f} % covered", flush=True)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--airlight", default="build/release/airlight", metavar="PATH")
    parser.add_argument("--folder", default=".", metavar="DIR")
    parser.add_argument("--texels", type=float, default=8.0, help="per metre")
    parser.add_argument("--spp", type=int, default=64, metavar="N", help="of the bakes")
    parser.add_argument("--picture-spp", type=int, default=64, metavar="N")
    parser.add_argument("--pixels", type=int, default=320, metavar="N")
    parser.add_argument("--page-pixels", type=int, default=260, metavar="N")
    parser.add_argument("--threads", type=int, default=1, metavar="N")
    options = parser.parse_args()
    options.root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    with tempfile.TemporaryDirectory() as folder:
        draw_room(options, folder)


if __name__ == "__main__":
    main()
