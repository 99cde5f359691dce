"""Reads and changes the folders that `airlight bake` writes (docs/lightmap-format.md)."""

import json
import os
import shutil

import numpy as np

import exr


def page_paths(folder):
    with open(os.path.join(folder, "lightmap.json"), encoding="utf-8") as file:
        return [os.path.join(folder, page["file"]) for page in json.load(file)["pages"]]


def only_media(source, out):
    """A copy of a lightmap whose other layers are dark."""
    shutil.copytree(source, out)
    for path in page_paths(out):
        page = exr.read(path)
        for c in "RGB":
            page["direct." + c] = page["indirect." + c] = np.zeros_like(page[c])
            page[c] = page["media." + c]
        exr.write(path, page)
