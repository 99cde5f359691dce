#!/usr/bin/env python3
"""Makes smoke: a plume rising from a fire bowl on open ground, under a low sun.

smoke.vol holds the density as a Mitsuba grid volume of 56 x 72 x 56 voxels; sky.hdr is the
environment, latitude and longitude, 256 x 128 texels, its centre column towards -Z and +X to its
right.
"""

import math
import os
import random
import struct
import sys

FOLDER = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(FOLDER, ".."))
from gltf_builder import Builder, write_json  # noqa: E402
from shapes import Shape, add, blob, dot, scale, sub, unit  # noqa: E402

LOW, HIGH = (-1.6, 0.45, -1.6), (1.6, 4.564, 1.6)  # cubic voxels of 57 mm
SIZE = (56, 72, 56)

TO_SUN = unit((-0.78, 0.36, -0.62))
SUN_RADIUS = math.radians(2.2)
SUN_IRRADIANCE = (6.0, 4.2, 2.5)  # W/m^2, perpendicular


# ---- density ----


class Noise:
    """Value noise on a periodic lattice of 32^3 random numbers: smooth, mean 0, in [-1, 1]."""

    def __init__(self, seed):
        rng = random.Random(seed)
        self.values = [rng.uniform(-1.0, 1.0) for _ in range(32 * 32 * 32)]

    def __call__(self, x, y, z):
        i, j, k = math.floor(x), math.floor(y), math.floor(z)
        u, v, w = x - i, y - j, z - k
        u, v, w = (t * t * t * (t * (6.0 * t - 15.0) + 10.0) for t in (u, v, w))
        values, i, i1 = self.values, i & 31, (i + 1) & 31
        rows = []
        for kk in (k & 31, (k + 1) & 31):
            for jj in (j & 31, (j + 1) & 31):
                base = (kk * 32 + jj) * 32
                rows.append(values[base + i] + u * (values[base + i1] - values[base + i]))
        low = rows[0] + v * (rows[1] - rows[0])
        high = rows[2] + v * (rows[3] - rows[2])
        return low + w * (high - low)


def puffs():
    """Balls along the plume's path: it starts narrow, swings in the wind and widens."""
    rng = random.Random(12)
    balls = []
    count = 46
    for n in range(count):
        t = n / (count - 1.0)
        height = 0.50 + 3.45 * t**0.9
        spread = 0.05 + 0.62 * t**1.3
        turn = rng.uniform(0.0, 2.0 * math.pi)
        away = spread * math.sqrt(rng.random())
        wind = 0.42 * t * t
        balls.append(
            (
                (away * math.cos(turn) + wind, height, 0.8 * away * math.sin(turn)),
                0.13 + 0.44 * t**0.8 * rng.uniform(0.7, 1.15),
            )
        )
    return balls


def density_grid():
    balls = puffs()
    coarse, fine = Noise(1), Noise(2)
    voxel = (HIGH[0] - LOW[0]) / SIZE[0]
    values = []
    for k in range(SIZE[2]):
        for j in range(SIZE[1]):
            y = LOW[1] + (j + 0.5) * voxel
            near = [ball for ball in balls if abs(ball[0][1] - y) < 1.6 * ball[1] + 0.3]
            for i in range(SIZE[0]):
                p = (LOW[0] + (i + 0.5) * voxel, y, LOW[2] + (k + 0.5) * voxel)
                values.append(density_at(p, near, coarse, fine))
    return values


def density_at(p, balls, coarse, fine):
    if not any(dot(sub(p, c), sub(p, c)) < (1.6 * r + 0.25) ** 2 for c, r in balls):
        return 0.0
    # The balls are looked up at a place that noise has moved: rolls and folds.
    q = scale(p, 2.3)
    moved = add(
        p,
        scale((coarse(*q), coarse(q[0] + 11.0, q[1], q[2]), coarse(q[0], q[1] + 17.0, q[2])), 0.16),
    )
    q = scale(p, 5.1)
    moved = add(
        moved, scale((fine(*q), fine(q[0] + 7.0, q[1], q[2]), fine(q[0], q[1], q[2] + 5.0)), 0.06)
    )
    depth = 0.0  # how far inside the ball that holds it best, in radii
    for c, r in balls:
        away = sub(moved, c)
        depth = max(depth, 1.0 - math.sqrt(dot(away, away)) / r)
    if depth <= 0.0:
        return 0.0
    q = scale(p, 7.7)
    wisps = 1.0 + 0.55 * coarse(*q) + 0.45 * fine(*scale(q, 2.1))
    thinning = 1.0 - 0.55 * (p[1] - LOW[1]) / (HIGH[1] - LOW[1])
    return max(0.0, min(1.0, 3.6 * depth * wisps)) * thinning


def write_vol(path, values):
    """Mitsuba's grid volume: "VOL", version 3, float32, one channel, bounds, x fastest."""
    with open(path, "wb") as file:
        file.write(b"VOL\x03" + struct.pack("<5i", 1, *SIZE, 1) + struct.pack("<6f", *LOW, *HIGH))
        file.write(struct.pack("<%df" % len(values), *values))


# ---- sky ----


def sky_radiance(d):
    up = d[1]
    toward_sun = dot(d, TO_SUN)
    if up < 0.0:
        return (0.16, 0.14, 0.11)
    horizon = math.exp(-6.0 * up)
    glow = math.exp(5.0 * (toward_sun - 1.0))
    color = [0.16 + 0.50 * horizon, 0.27 + 0.42 * horizon, 0.50 + 0.28 * horizon]
    warm = (1.5, 0.80, 0.32)
    return tuple(c + g * (0.35 + 0.65 * horizon) * glow for c, g in zip(color, warm))


def write_sky(path, width=256, height=128, parts=6):
    """Radiance RGBE, not run-length encoded; a texel is sun as far as parts x parts points are."""
    cos_sun = math.cos(SUN_RADIUS)
    sun = scale(SUN_IRRADIANCE, 1.0 / (math.pi * math.sin(SUN_RADIUS) ** 2))
    data = bytearray()
    for y in range(height):
        for x in range(width):
            hits, total = 0, (0.0, 0.0, 0.0)
            for k in range(parts * parts):
                d = sky_direction(
                    (x + (k % parts + 0.5) / parts) / width,
                    (y + (k // parts + 0.5) / parts) / height,
                )
                hits += dot(d, TO_SUN) > cos_sun
                if k % 7 == 0:
                    total = add(total, sky_radiance(d))
            color = scale(total, 1.0 / len(range(0, parts * parts, 7)))
            data += rgbe(add(color, scale(sun, hits / float(parts * parts))))
    with open(path, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width))
        file.write(data)


def sky_direction(u, v):
    theta, phi = math.pi * v, 2.0 * math.pi * (u - 0.5)
    return (math.sin(theta) * math.sin(phi), math.cos(theta), -math.sin(theta) * math.cos(phi))


def rgbe(color):
    mantissa, exponent = math.frexp(max(color))
    return bytes([int(c * 256.0 / 2.0**exponent) for c in color] + [exponent + 128])


# ---- what stands on the ground ----


def ground(builder):
    earth = builder.material("earth", (0.23, 0.19, 0.14), specular=0.0)
    shape = Shape(earth)
    ring = [
        (90.0 * math.cos(a), 0.0, -90.0 * math.sin(a))
        for a in (2.0 * math.pi * k / 48 for k in range(48))
    ]
    shape.face(ring)
    builder.mesh("ground", shape)

    stone = builder.material("stone", (0.30, 0.28, 0.26), specular=0.0)
    stones = Shape(stone)
    rng = random.Random(3)
    spots = [
        (0.95 * math.cos(a), 0.95 * math.sin(a), rng.uniform(0.13, 0.21))
        for a in (2.0 * math.pi * (k + rng.uniform(-0.2, 0.2)) / 13 for k in range(13))
    ]
    spots += [(-2.9, -1.5, 0.55), (-2.2, -2.1, 0.30), (3.1, -2.6, 0.65), (2.5, 1.1, 0.24)]
    for x, z, size in spots:
        turn = rng.uniform(0.0, 6.0)
        stones.join(
            blob(
                stone,
                (x, 0.55 * size, z),
                (size, 0.72 * size, size),
                lambda p, turn=turn: (
                    1.0
                    + 0.16 * math.sin(2.5 * p[0] + turn)
                    + 0.13 * math.sin(3.0 * p[2] - 2.0 * turn)
                ),
            )
        )
    builder.mesh("stones", stones)


def fire_bowl(builder):
    iron = builder.material("iron", (0.09, 0.085, 0.08), roughness=0.55, metallic=1.0)
    shape = Shape(iron).lathe(
        [
            (0.0, 0.21),
            (0.15, 0.22),
            (0.32, 0.32),
            (0.42, 0.50),
            (0.44, 0.50),
            (0.44, 0.52),
            (0.40, 0.52),
            (0.30, 0.35),
            (0.14, 0.26),
            (0.0, 0.25),
        ],
        40,
    )
    shape.lathe(
        [(0.0, 0.0), (0.24, 0.0), (0.24, 0.03), (0.07, 0.06), (0.06, 0.22), (0.0, 0.22)], 32
    )
    builder.mesh("fire bowl", shape)


def sidecar():
    return {
        "media": [
            {
                "name": "smoke",
                "sigma_s": [8.2, 8.2, 8.2],
                "sigma_a": [0.75, 0.85, 1.0],
                "g": 0.5,
                "density": {"grid": {"file": "smoke.vol"}},
            }
        ],
        "lights": [
            {"name": "sky", "type": "environment", "image": "sky.hdr"},
            {
                "name": "fire",
                "type": "point",
                "position": [0.0, 0.47, 0.0],
                "intensity": [5.0, 2.1, 0.55],
            },
        ],
    }


def main():
    write_vol(os.path.join(FOLDER, "smoke.vol"), density_grid())
    write_sky(os.path.join(FOLDER, "sky.hdr"))
    builder = Builder("smoke")
    ground(builder)
    fire_bowl(builder)
    builder.camera("camera", (0.5, 1.35, 7.2), (0.15, 2.1, 0.0), math.radians(42.0), 4.0 / 3.0)
    builder.write(FOLDER, "smoke")
    write_json(os.path.join(FOLDER, "smoke.airlight.json"), sidecar())


main()
