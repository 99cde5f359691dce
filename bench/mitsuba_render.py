#!/usr/bin/env python3
"""Renders a scene by Mitsuba 3 once with each of as many seeds as are asked for: the pictures, and
seconds of rendering of each. Needs Mitsuba 3 and NumPy.

    python3 bench/mitsuba_render.py VARIANT SCENE.xml SAMPLES SEEDS OUT.npy

SAMPLES are those of each seed. A picture is rendered whenever a line is read, and its seconds are
printed. One more, which compiles, goes before them and does not count.
"""

import sys
import time

import mitsuba
import numpy as np


def main():
    variant, scene, samples, seeds, out = sys.argv[1:]
    mitsuba.set_variant(variant)
    loaded = mitsuba.load_file(scene)
    pictures = []
    for seed in range(int(seeds) + 1):
        if seed > 0 and not sys.stdin.readline():
            sys.exit("mitsuba_render: expected a line for each seed")
        begin = time.perf_counter()
        pictures.append(np.array(mitsuba.render(loaded, spp=int(samples), seed=seed), np.float64))
        print(time.perf_counter() - begin, flush=True)
    np.save(out, np.stack(pictures[1:])[..., :3])


if __name__ == "__main__":
    main()
