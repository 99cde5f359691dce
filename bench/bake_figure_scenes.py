"""The settings of two figures of [Dubouchet2019] with geometry of our own, for bake_figures.py.

Lengths are metres, +Y is up, light is radiometric; nothing is lost in the media (albedo 1), which
scatter evenly to all sides."""

import math
import os
import struct
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenes"))
from gltf_builder import Builder, write_json  # noqa: E402
from shapes import Shape, placed  # noqa: E402

HAZE = 0.5  # per metre, in the box of 2 m
BALLS = (((-0.75, 0.75, 0.1), 0.55), ((0.45, 1.05, -0.35), 0.7), ((0.9, 0.5, 0.65), 0.4))
THICK = 4.0  # per metre, inside the balls
GRID_LOW, GRID_HIGH, GRID_SIZE = (-1.5, 0.0, -1.2), (1.5, 1.8, 1.2), (40, 24, 32)


def lambert(builder, name, color):
    return builder.material(name, color, specular=0.0)


def add_box(builder):
    """Five walls that look inwards, open at +z, and two blocks."""
    white = lambert(builder, "white", (0.7, 0.7, 0.7))
    red = lambert(builder, "red", (0.6, 0.06, 0.05))
    green = lambert(builder, "green", (0.1, 0.45, 0.08))
    a, b, c, d = (-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)
    e, f, g, h = (-1, 2, 1), (1, 2, 1), (1, 2, -1), (-1, 2, -1)
    walls = (
        ("floor", white, (a, b, c, d)),
        ("ceiling", white, (h, g, f, e)),
        ("back", white, (d, c, g, h)),
        ("left", red, (a, d, h, e)),
        ("right", green, (c, b, f, g)),
    )
    for name, material, corners in walls:
        shape = Shape(material)
        shape.face(corners)
        builder.mesh(name, shape)
    for name, high, x, z, turn in (("tall", 1.2, -0.35, -0.3, 0.3), ("low", 0.6, 0.35, 0.3, -0.3)):
        block = Shape(white).box((-0.29, 0.0, -0.29), (0.29, high, 0.29))
        builder.mesh(name, Shape(white).join(block, placed(x, 0.0, z, turn)))


def box_scene(folder):
    """Fig. 9: a box of haze that fills a Cornell box, lit by a lamp in its ceiling."""
    builder = Builder("Cornell box in haze")
    add_box(builder)
    builder.camera("camera", (0.0, 1.0, 4.4), (0.0, 1.0, 0.0), math.radians(36.0), 1.0)
    builder.write(folder, "box")
    lamp = [[-0.3, 1.98, -0.3], [0.3, 1.98, -0.3], [0.3, 1.98, 0.3], [-0.3, 1.98, 0.3]]
    haze = {"min": [-0.99, 0.01, -0.99], "max": [0.99, 1.99, 0.99]}
    sidecar = {
        "media": [{"name": "haze", "sigma_s": HAZE, "boundary": {"box": haze}}],
        "lights": [{"type": "polygon", "name": "lamp", "vertices": lamp, "radiance": [9, 8, 6]}],
    }
    write_json(os.path.join(folder, "box.airlight.json"), sidecar)
    return os.path.join(folder, "box.gltf")


def density(i, j, k):
    """1 in the balls, 0 elsewhere: no density in between."""
    at = (i, j, k)
    p = [
        low + (high - low) * (n + 0.5) / size
        for low, high, n, size in zip(GRID_LOW, GRID_HIGH, at, GRID_SIZE)
    ]
    return float(any(math.dist(p, centre) < radius for centre, radius in BALLS))


def balls_scene(folder):
    """Fig. 8: dense fog with hard borders, both lamps outside of it."""
    builder = Builder("Balls of fog, lamps outside")
    grey = lambert(builder, "grey", (0.6, 0.6, 0.6))
    floor, back = Shape(grey), Shape(lambert(builder, "warm", (0.6, 0.5, 0.4)))
    floor.face(((-3, 0, 2), (3, 0, 2), (3, 0, -1.6), (-3, 0, -1.6)))
    back.face(((-3, 0, -1.6), (3, 0, -1.6), (3, 2.4, -1.6), (-3, 2.4, -1.6)))
    builder.mesh("floor", floor)
    builder.mesh("back", back)
    builder.camera("camera", (0.0, 2.6, 5.6), (0.0, 0.7, -0.4), math.radians(36.0), 1.0)
    builder.write(folder, "balls")
    with open(os.path.join(folder, "balls.vol"), "wb") as file:
        x, y, z = GRID_SIZE
        file.write(b"VOL\x03" + struct.pack("<5i", 1, x, y, z, 1))
        file.write(struct.pack("<6f", *GRID_LOW, *GRID_HIGH))
        values = [density(i, j, k) for k in range(z) for j in range(y) for i in range(x)]
        file.write(struct.pack("<%df" % len(values), *values))
    lamps = (("left", (-2.2, 2.2, 0.6), [12, 8, 5]), ("right", (2.3, 1.7, 0.9), [5, 8, 12]))
    grid = {"grid": {"file": "balls.vol"}}
    sidecar = {
        "media": [{"name": "fog", "sigma_s": THICK, "density": grid}],
        "lights": [
            {"type": "point", "name": name, "position": list(at), "intensity": intensity}
            for name, at, intensity in lamps
        ],
    }
    write_json(os.path.join(folder, "balls.airlight.json"), sidecar)
    return os.path.join(folder, "balls.gltf")
