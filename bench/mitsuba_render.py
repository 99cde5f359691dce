#!/usr/bin/env python3
"""Renders a scene by Mitsuba 3 with as many seeds as are asked for: mean, variance of the mean, and
seconds of rendering. Needs Mitsuba 3 and NumPy.

    python3 bench/mitsuba_render.py VARIANT SCENE.xml SAMPLES SEEDS OUT.npz

SAMPLES are those of each seed. The first call of all, which compiles, does not count.
"""

import sys
import time

import mitsuba
import numpy as np


def main():
    variant, scene, samples, seeds, out = sys.argv[1:]
    mitsuba.set_variant(variant)
    loaded = mitsuba.load_file(scene)
    np.array(mitsuba.render(loaded, spp=int(samples), seed=1000))
    pictures, begin = [], time.perf_counter()
    for seed in range(int(seeds)):
        pictures.append(np.array(mitsuba.render(loaded, spp=int(samples), seed=seed), np.float64))
    seconds = time.perf_counter() - begin
    pictures = np.stack(pictures)[..., :3]
    np.savez(
        out,
        mean=pictures.mean(0),
        variance=pictures.var(0, ddof=1) / int(seeds),
        seconds=seconds,
    )


if __name__ == "__main__":
    main()
