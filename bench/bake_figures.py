#!/usr/bin/env python3
"""Two figures of [Dubouchet2019] with scenes of our own: what each treatment of fog bakes onto
surfaces, beside volumetric path tracing. Needs NumPy and Pillow.

    python3 bench/bake_figures.py --sheet docs/bake-figures.png

Fig. 9: a Cornell box full of haze, paths of ten events. Fig. 8: dense fog with hard borders, the
lamps outside of it. Printed are mean |difference| and bias of the media layer (light that fog has
scattered), relative to its mean in the reference, over all covered texels without denoising; the
last row, `reference` with other random numbers and as many samples as the modes, shows the noise in
them. impulse+back adds what impulse lacks by its nature, light that a surface sends into the fog
and gets back itself, by the closed form for a wide floor of radiosity B under a slab of optical
thickness T, alpha B times the integral of E_2(t)^2 from 0 to T, T reaching to the wall opposite.

The sheet has, from above, for each scene the surfaces by `airlight render --lightmap`, the same of
the media layer alone, and its difference to the reference, red where it is too much, blue where it
is too little, full at half of the mean.
"""

import argparse
import os
import shutil
import subprocess
import tempfile

import numpy as np
from PIL import Image, ImageDraw

import bake_figure_scenes as scenes
import exr
from lightmap_folder import only_media, page_paths

SHOWN = ("none", "attenuate", "literal", "impulse", "exact", "reference")
MODES = ("none", "attenuate", "literal", "impulse", "impulse+back", "exact", "reference")
LABEL = 14


# ---- baking ----


def bake(options, scene, mode, out, spp, seed):
    media, extra = ("impulse", ["--impulse-literal"]) if mode == "literal" else (mode, [])
    command = [options.airlight, "bake", scene, "-o", out, "-q", "-t", str(options.threads)]
    command += ["--media", media, *extra, "--spp", str(spp), "--seed", str(seed)]
    command += ["--texels-per-metre", str(options.texels), "--bounces", str(options.bounces)]
    command += ["--no-denoise", "--no-stitch", "--full", "--no-resume"]
    subprocess.run(command, check=True)


def slab_back_scatter(thickness):
    """Integral of E_2(t)^2 from 0 to thickness; (2/3)(1 - ln 2) = 0.2046 for a half space."""
    t = (np.arange(2000) + 0.5) / 2000 * thickness
    mu = (np.arange(2000) + 0.5) / 2000
    e2 = np.array([np.exp(-x / mu).mean() for x in t])
    return (e2 * e2).mean() * thickness


def add_back_scatter(source, out, thickness):
    shutil.copytree(source, out)
    share = slab_back_scatter(thickness)
    for path in page_paths(out):
        page = exr.read(path)
        for c in "RGB":
            more = share * page["albedo." + c] * page[c]
            page["media." + c] += more
            page[c] += more
        exr.write(path, page)


# ---- comparing ----


def layer_texels(folders, layer):
    """Of each folder texels x 3 of all pages, those that all of them have; "" is the sum."""
    found = [[] for _ in folders]
    for paths in zip(*(page_paths(folder) for folder in folders)):
        pages = [exr.read(path) for path in paths]
        covered = np.all([page["coverage.Y"] > 0.0 for page in pages], 0)
        for texels, page in zip(found, pages):
            texels.append(exr.colour(page, layer)[covered])
    return [np.concatenate(texels) for texels in found]


def print_errors(title, bakes, truth):
    print(f"{title}: media is {100 * share_of_media(truth):.1f} % of the light")
    print(f"  {'mode':<14} {'media: error':>12} {'bias':>9}   {'all: error':>12} {'bias':>9}")
    for mode, folder in bakes.items():
        line = f"  {mode:<14}"
        for layer in ("media", ""):
            a, b = layer_texels((folder, truth), layer)
            error, bias = np.abs(a - b).mean() / b.mean(), (a - b).mean() / b.mean()
            line += f" {100 * error:11.2f} % {100 * bias:+8.2f} % "
        print(line, flush=True)


def share_of_media(folder):
    return layer_texels((folder,), "media")[0].mean() / layer_texels((folder,), "")[0].mean()


# ---- pictures ----


def render(options, scene, lightmap, terms, out):
    """Surfaces by the lightmap, with what the fog takes away before the eye."""
    command = [options.airlight, "render", scene, "--lightmap", lightmap, "--terms", terms, "-q"]
    command += ["-o", out, "--width", str(options.pixels), "--height", str(options.pixels)]
    subprocess.run(command + ["--spp", "64", "-t", str(options.threads)], check=True)
    return exr.colour(exr.read(out))


def shown(light, scale):
    x = np.clip(light * scale, 0.0, 1.0)
    x = np.where(x < 0.0031308, x * 12.92, 1.055 * np.maximum(x, 0.0031308) ** (1 / 2.4) - 0.055)
    return Image.fromarray(np.round(255.0 * x).astype(np.uint8))


def signed(a, b, mean):
    """Red where a is more than b, blue where less; full at half of the mean."""
    x = np.clip(2.0 * (a.mean(-1) - b.mean(-1)) / mean, -1.0, 1.0)
    rgb = np.stack([1 - np.maximum(-x, 0), 1 - np.abs(x), 1 - np.maximum(x, 0)], -1)
    return Image.fromarray(np.round(255.0 * rgb).astype(np.uint8))


def draw_rows(options, scene, bakes, truth, folder, sheet, top):
    draw = ImageDraw.Draw(sheet)
    path = os.path.join(folder, "picture.exr")
    media_of = {}
    for mode, bake_folder in {**bakes, "truth": truth}.items():
        alone = os.path.join(folder, "media-" + mode)
        only_media(bake_folder, alone)
        media_of[mode] = render(options, scene, alone, "S+", path)
    mean = media_of["truth"].mean()
    bright = np.percentile(render(options, scene, truth, "S0,S+", path), 99.0)
    media_bright = np.percentile(media_of["truth"], 99.5)
    for column, mode in enumerate(SHOWN):
        source = truth if mode == "reference" else bakes[mode]
        light = media_of["truth" if mode == "reference" else mode]
        whole = render(options, scene, source, "S0,S+", path)
        images = (
            (mode, shown(whole, 0.8 / bright)),
            ("media", shown(light, 0.8 / media_bright)),
            ("media - reference", signed(light, media_of["truth"], mean)),
        )
        for row, (text, image) in enumerate(images):
            at = (column * options.pixels, top + row * (options.pixels + LABEL))
            draw.text((at[0] + 3, at[1] + 1), text, fill="black")
            sheet.paste(image, (at[0], at[1] + LABEL))


def run(options, title, scene, thickness, folder, sheet, top):
    bakes = {}
    for mode in MODES:
        out = os.path.join(folder, mode)
        if mode == "impulse+back":
            if thickness == 0.0:
                continue
            add_back_scatter(bakes["impulse"], out, thickness)
        else:
            bake(options, scene, mode, out, options.spp, 3)
        bakes[mode] = out
    truth = os.path.join(folder, "truth")
    bake(options, scene, "reference", truth, options.reference, 1)
    print_errors(title, bakes, truth)
    if sheet is not None:
        draw_rows(options, scene, bakes, truth, folder, sheet, top)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--airlight", default="build/release/airlight", metavar="PATH")
    parser.add_argument("--texels", type=float, default=12.0, help="per metre")
    parser.add_argument("--spp", type=int, default=512, metavar="N")
    parser.add_argument("--reference", type=int, default=4096, metavar="N")
    parser.add_argument("--bounces", type=int, default=10, metavar="N")
    parser.add_argument("--threads", type=int, default=1, metavar="N")
    parser.add_argument("--pixels", type=int, default=130, metavar="N")
    parser.add_argument("--sheet", metavar="PNG")
    options = parser.parse_args()
    size = (options.pixels * len(SHOWN), 6 * (options.pixels + LABEL))
    sheet = Image.new("RGB", size, "white") if options.sheet else None
    settings = (
        ("Fig. 9, box of haze", scenes.box_scene, 2.0 * scenes.HAZE),
        ("Fig. 8, balls of fog", scenes.balls_scene, 0.0),
    )
    for number, (title, make, thickness) in enumerate(settings):
        with tempfile.TemporaryDirectory() as folder:
            top = number * 3 * (options.pixels + LABEL)
            run(options, title, make(folder), thickness, folder, sheet, top)
    if sheet is not None:
        sheet.quantize(256, dither=Image.Dither.NONE).save(options.sheet, optimize=True)


if __name__ == "__main__":
    main()
