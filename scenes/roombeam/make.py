#!/usr/bin/env python3
"""Makes roombeam: a grey sphere over a floor in a box of haze, lit by one collimated light.

It is defined with z up and turned to glTF's +Y up by (x, y, z) -> (x, z, -y): medium box 4 x 4 x
3 m on the ground, sigma_s 0.25, sigma_a 0.05 per metre, g 0.3; floor 12 x 12 m 1 mm below it;
sphere of radius 0.5 m, centre (0, 0, 1.5); both diffuse, albedo 0.5; light along (1, 0, -1),
perpendicular irradiance pi W/m^2; camera (0, -7, 2) looking at (0, 0, 1.3), 40 degrees high, 4:3.

The sphere is an icosahedron subdivided five times (20,480 triangles): the widest face spans
0.0239 rad from its centre to a corner, so that faces lie at most 0.5 m * 0.0239^2 / 2 = 0.14 mm
inside the sphere. By Cauchy's formula its mean silhouette is a quarter of its surface: 0.030 %
too small, and so is its shadow. As both cover less than a tenth of the picture, the picture's
mean changes by less than 0.003 %.
"""

import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from gltf_builder import Builder, write_json  # noqa: E402
from shapes import Shape, icosphere  # noqa: E402


def turned(x, y, z):
    return (x, z, 0.0 - y)


def main():
    folder = os.path.dirname(os.path.abspath(__file__))
    builder = Builder("roombeam")
    grey = builder.material("grey", (0.5, 0.5, 0.5), specular=0.0)

    floor = Shape(grey)
    floor.face(
        [
            turned(*p)
            for p in (
                (-6.0, -6.0, -0.001),
                (6.0, -6.0, -0.001),
                (6.0, 6.0, -0.001),
                (-6.0, 6.0, -0.001),
            )
        ]
    )
    builder.mesh("floor", floor)
    builder.mesh("sphere", icosphere(grey, turned(0.0, 0.0, 1.5), 0.5, 5))
    builder.camera(
        "camera", turned(0.0, -7.0, 2.0), turned(0.0, 0.0, 1.3), math.radians(40.0), 4.0 / 3.0
    )
    builder.write(folder, "roombeam")

    write_json(
        os.path.join(folder, "roombeam.airlight.json"),
        {
            "media": [
                {
                    "name": "haze",
                    "sigma_s": 0.25,
                    "sigma_a": 0.05,
                    "g": 0.3,
                    "boundary": {"box": {"min": [-2.0, 0.0, -2.0], "max": [2.0, 3.0, 2.0]}},
                }
            ],
            "lights": [
                {
                    "name": "sun",
                    "type": "collimated",
                    "direction": turned(1.0, 0.0, -1.0),
                    "irradiance": math.pi,
                }
            ],
        },
    )


main()
