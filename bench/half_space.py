#!/usr/bin/env python3
"""A dense medium behind a boundary that bends no light, under an even sky, beside the closed form
[Chandrasekhar1960]: by `airlight render --method path`, and by Mitsuba 3 where a Python that has it
is given; the same scene in several units of length. Needs NumPy.

    python3 bench/half_space.py --mitsuba PYTHON

The body is a cube of 300 mean free paths each way, looked at from 60 degrees. Printed are radiance,
its standard error, and percent off the closed form."""

import argparse
import os
import tempfile

import numpy as np

import exr
import truth

ALBEDOS = (1.0 / 3.0, 0.7, 0.9)
COSINE = 0.5
SAMPLES = 16384
SIDE = 8  # pixels

SCENE = """<scene version="3.0.0">
  <integrator type="volpath"><integer name="max_depth" value="-1"/></integrator>
  <sensor type="orthographic">
    <transform name="to_world">
      <scale value="{small}"/>
      <lookat origin="{x}, {y}, 0" target="0, 0, 0" up="0, 1, 0"/>
    </transform>
    <film type="hdrfilm">
      <integer name="width" value="{side}"/><integer name="height" value="{side}"/>
      <rfilter type="box"/>
    </film>
    <sampler type="independent"/>
  </sensor>
  <shape type="cube">
    <transform name="to_world">
      <translate x="0" y="-1" z="0"/><scale value="{unit}"/>
    </transform>
    <bsdf type="null"/>
    <medium type="homogeneous" name="interior">
      <rgb name="albedo" value="{albedos}"/>
      <float name="scale" value="{density}"/><rgb name="sigma_t" value="1, 1, 1"/>
    </medium>
  </shape>
  <emitter type="constant"><rgb name="radiance" value="1, 1, 1"/></emitter>
</scene>
"""


def h_function(albedo, mu):
    """By iteration of its integral equation."""
    x, w = np.polynomial.legendre.leggauss(64)
    x, w = (x + 1.0) / 2.0, w / 2.0
    root, h = np.sqrt(1.0 - albedo), np.ones(64)
    for _ in range(500):
        h = 1.0 / (root + albedo / 2.0 * (w * x * h / (x + x[:, None])).sum(1))
    return 1.0 / (root + albedo / 2.0 * (w * x * h / (x + mu)).sum())


def write(path, unit):
    text = SCENE.format(
        side=SIDE,
        unit=unit,
        small=0.05 * unit,
        x=-2.0 * unit * np.sqrt(1.0 - COSINE**2),
        y=2.0 * unit * COSINE,
        albedos=", ".join(f"{a:.9g}" for a in ALBEDOS),
        density=300.0 / unit,
    )
    with open(path, "w") as file:
        file.write(text)


def whole(picture):
    """Mean of the picture's channels, and standard errors."""
    pixels = picture.mean[..., 0].size
    return picture.mean.mean((0, 1)), np.sqrt(picture.variance.sum((0, 1))) / pixels


def ours(options, scene):
    return whole(truth.ours(options)(scene, (SIDE, SIDE), None, SAMPLES))


def theirs(options, scene):
    return whole(truth.mitsuba_picture(options, "scalar_rgb", scene, SAMPLES))


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--airlight", default=os.path.join(here, "../build/release/airlight"))
    parser.add_argument("--mitsuba", help="a Python that has Mitsuba 3")
    parser.add_argument("--units", type=float, nargs="+", default=[0.01, 1.0, 100.0])
    options = parser.parse_args()
    expected = np.array([1.0 - np.sqrt(1.0 - a) * h_function(a, COSINE) for a in ALBEDOS])
    print("closed form", *(f"{e:.5f}" for e in expected))
    renderers = [("airlight", ours)] + ([("mitsuba", theirs)] if options.mitsuba else [])
    with tempfile.TemporaryDirectory() as options.folder:
        scene = os.path.join(options.folder, "scene.xml")
        for unit in options.units:
            write(scene, unit)
            for name, render in renderers:
                mean, error = render(options, scene)
                off = 100.0 * (mean / expected - 1.0)
                cells = (f"{m:.5f} +- {e:.5f} ({o:+.2f} %)" for m, e, o in zip(mean, error, off))
                print(f"unit {unit:g}, {name}:", *cells, flush=True)


if __name__ == "__main__":
    main()
