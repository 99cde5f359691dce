#!/usr/bin/env python3
"""Contact sheet of every mode of the collimated method: M1 of sunroom's sun at 4 samples per pixel,
and beneath each its difference from exact shadows, scaled alike. Needs Pillow.

    python3 bench/collimated_sheet.py build/release/airlight docs/collimated-modes.png
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from PIL import Image, ImageDraw

MODES = ["exact", "rm", "ds", "wvds", "rees", "reds", "me", "me6", "me-ideal", "me6-ideal"]
COLUMNS, WIDTH, HEIGHT, LABEL = 5, 320, 180, 16


def sun_only(source, folder):
    """A copy of the scene without its other lights."""
    for name in os.listdir(source):
        if not name.endswith(".py"):
            shutil.copy(os.path.join(source, name), folder)
    sidecar = os.path.join(folder, "sunroom.airlight.json")
    with open(sidecar, encoding="utf-8") as file:
        content = json.load(file)
    content["lights"] = [light for light in content["lights"] if light["name"] == "sun"]
    with open(sidecar, "w", encoding="utf-8") as file:
        json.dump(content, file)
    return os.path.join(folder, "sunroom.gltf")


def main():
    airlight, out = sys.argv[1], sys.argv[2]
    root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    rows = (len(MODES) + COLUMNS - 1) // COLUMNS
    sheet = Image.new("RGB", (COLUMNS * WIDTH, rows * 2 * (HEIGHT + LABEL)), "white")
    draw = ImageDraw.Draw(sheet)
    with tempfile.TemporaryDirectory() as folder:
        def at(name):
            return os.path.join(folder, name)

        scene = sun_only(os.path.join(root, "scenes", "sunroom"), folder)
        for i, mode in enumerate(MODES):
            command = [airlight, "render", scene, "--width", str(WIDTH), "--height", str(HEIGHT)]
            command += ["--max-depth", "1", "--terms", "M1", "--spp", "4", "--filter", "point", "-q"]
            command += ["--method", f"collimated:{mode}", "--exposure", "1.5"]
            subprocess.run(command + ["-o", at(mode + ".exr"), "-o", at(mode + ".png")], check=True)
            diff = subprocess.run([airlight, "diff", at(mode + ".exr"), at("exact.exr"),
                                   "--false-colour", at(mode + ".diff.png"), "--scale", "0.15"],
                                  check=True, capture_output=True, text=True).stdout
            psnr = re.search(r"psnr\s+(\S+)", diff).group(1)
            x, y = i % COLUMNS * WIDTH, i // COLUMNS * 2 * (HEIGHT + LABEL)
            for name, text in ((mode + ".png", mode), (mode + ".diff.png", f"|{mode} - exact|, {psnr} dB")):
                draw.text((x + 4, y + 2), text, fill="black")
                sheet.paste(Image.open(at(name)).convert("RGB"), (x, y + LABEL))
                y += HEIGHT + LABEL
    sheet.save(out)


if __name__ == "__main__":
    main()
