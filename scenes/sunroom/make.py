#!/usr/bin/env python3
"""Makes sunroom: a furnished room on a hazy morning, the sun coming through three windows.

Inside the room is 6.4 m wide (x), 5.6 m deep (z) and 2.9 m high (y), the floor at y = 0. The
windows are in the wall at x = -3.2. Walls, floor and roof are closed boxes that overlap at the
corners, so that no light leaks in.
"""

import math
import os
import random
import sys

FOLDER = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(FOLDER, ".."))
from gltf_builder import Builder, write_json, write_png  # noqa: E402
from shapes import Shape, add, blob, icosphere, placed, scale  # noqa: E402

HALF_X, HALF_Z, HEIGHT = 3.2, 2.8, 2.9
WALL = 0.35
WINDOWS = (-1.86, 0.0, 1.86)  # centres along z
WINDOW_HALF, SILL, LINTEL = 0.68, 0.14, 2.42

SUN_TRAVELS = (0.86, -0.37, 0.27)
SUN_IRRADIANCE = (20.0, 16.5, 12.0)  # W/m^2: about 12,000 lx
SKY_RADIANCE = (0.42, 0.60, 0.90)
LAMP_RADIANCE = (64.0, 39.0, 18.0)
HAZE = {"sigma_s": [0.11, 0.11, 0.11], "sigma_a": [0.004, 0.004, 0.004], "g": 0.45}


# ---- pictures ----


def lattice(x, y, seed):
    """A fixed random number in [0, 1) for each point with whole coordinates."""
    n = (x * 374761393 + y * 668265263 + seed * 2147483647) & 0xFFFFFFFF
    n = ((n ^ (n >> 13)) * 1274126177) & 0xFFFFFFFF
    return (n ^ (n >> 16)) / 2.0**32


def noise(x, y, seed, period):
    """Value noise that repeats after `period` in both directions."""
    i, j = math.floor(x), math.floor(y)
    u, v = x - i, y - j
    u, v = u * u * (3.0 - 2.0 * u), v * v * (3.0 - 2.0 * v)

    def at(di, dj):
        return lattice((i + di) % period, (j + dj) % period, seed)

    return (at(0, 0) * (1 - u) + at(1, 0) * u) * (1 - v) + (at(0, 1) * (1 - u) + at(1, 1) * u) * v


def mix(a, b, t):
    return tuple(p + (q - p) * t for p, q in zip(a, b))


def write_planks(path, size=512, rows=8):
    """Oak planks along u: 8 rows, each with one joint."""

    def pixel(x, y):
        row = y * rows // size
        joint = int(lattice(row, 0, 5) * size)
        plank = 2 * row + (1 if (x - joint) % size < size // 2 else 0)
        across = (y * rows / size) % 1.0
        along = ((x - joint) % (size // 2)) / (size // 2)
        grain = noise(x * 16 / size + 7 * plank, y * 128 / size, plank, 128)
        streak = noise(x * 4 / size + 3 * plank, y * 32 / size, plank + 50, 32)
        tone = 0.62 + 0.26 * lattice(plank, 1, 9) + 0.16 * (grain - 0.5) + 0.22 * (streak - 0.5)
        gap = min(across, 1.0 - across) < 0.028 or min(along, 1.0 - along) < 0.006
        return scale((0.52, 0.30, 0.145), tone * (0.35 if gap else 1.0))

    write_png(path, size, size, pixel)


def write_rug(path, width=256, height=160):
    """A woven border round a field of diamonds."""
    red, cream, blue = (0.30, 0.045, 0.035), (0.62, 0.50, 0.34), (0.04, 0.075, 0.15)

    def pixel(x, y):
        edge = min(x, y, width - 1 - x, height - 1 - y)
        weave = 0.82 + 0.18 * lattice(x, y, 3)
        if edge < 5:
            color = cream
        elif edge < 20:
            color = blue if (x + y) // 8 % 2 else mix(blue, cream, 0.35)
        elif edge < 24:
            color = cream
        else:
            diamond = abs((x - width / 2) % 40 - 20) + abs((y - height / 2) % 40 - 20)
            color = cream if 17 < diamond < 20 else blue if diamond < 7 else red
        return scale(color, weave)

    write_png(path, width, height, pixel)


def write_painting(path, size=128):
    """Hills under a morning sky."""

    def pixel(x, y):
        u, v = x / size, 1.0 - y / size
        color = mix((0.85, 0.55, 0.30), (0.20, 0.36, 0.60), min(1.0, max(0.0, (v - 0.45) * 2.2)))
        if (u - 0.68) ** 2 + (v - 0.62) ** 2 < 0.006:
            color = (0.95, 0.82, 0.50)
        for layer in range(4):
            crest = (
                0.52
                - 0.12 * layer
                + 0.10 * (noise(u * (3 + layer) + 9 * layer, 0.5, layer, 64) - 0.5)
                + 0.03 * math.sin(9.0 * u + 2.0 * layer)
            )
            if v < crest:
                color = mix((0.35, 0.42, 0.45), (0.06, 0.13, 0.05), layer / 3.0)
        return scale(color, 0.88 + 0.12 * noise(x / 3.0, y / 3.0, 8, 64))

    write_png(path, size, size, pixel)


# ---- the building ----


def walls(builder, paint):
    x0, x1, z0, z1 = -HALF_X, HALF_X, -HALF_Z, HALF_Z
    top = HEIGHT + WALL
    shell = Shape(paint["plaster"])
    shell.box((x0 - WALL, -WALL, z0 - WALL), (x1 + WALL, top, z0))
    shell.box((x0 - WALL, -WALL, z1), (x1 + WALL, top, z1 + WALL))
    shell.box((x1, -WALL, z0 - WALL), (x1 + WALL, top, z1 + WALL))
    # The wall with the windows: a band below, a band above, and piers that reach into both.
    shell.box((x0 - WALL, -WALL, z0 - WALL), (x0, SILL, z1 + WALL))
    shell.box((x0 - WALL, LINTEL, z0 - WALL), (x0, top, z1 + WALL))
    edges = (
        [z0 - WALL] + [z for c in WINDOWS for z in (c - WINDOW_HALF, c + WINDOW_HALF)] + [z1 + WALL]
    )
    for a, b in zip(edges[0::2], edges[1::2]):
        shell.box((x0 - WALL, SILL - 0.1, a), (x0, LINTEL + 0.1, b))
    builder.mesh("walls", shell)

    ceiling = Shape(paint["ceiling"])
    ceiling.box(
        (x0 - WALL - 0.4, HEIGHT, z0 - WALL - 0.4), (x1 + WALL + 0.4, top + 0.1, z1 + WALL + 0.4)
    )
    builder.mesh("ceiling", ceiling)

    floor = Shape(paint["planks"], uv_scale=1.0 / 1.6)
    floor.box((x0 - 0.1, -WALL, z0 - 0.1), (x1 + 0.1, 0.0, z1 + 0.1))
    builder.mesh("floor", floor)

    skirting = Shape(paint["white"])
    skirting.box((x0 - 0.01, -0.01, z0), (x0 + 0.02, 0.11, z1), 0.006)
    skirting.box((x1 - 0.02, -0.01, z0), (x1 + 0.01, 0.11, z1), 0.006)
    skirting.box((x0, -0.01, z0 - 0.01), (x1, 0.11, z0 + 0.02), 0.006)
    skirting.box((x0, -0.01, z1 - 0.02), (x1, 0.11, z1 + 0.01), 0.006)
    builder.mesh("skirting", skirting)

    beams = Shape(paint["dark oak"])
    for z in (-2.2, -1.1, 0.0, 1.1, 2.2):
        beams.box(
            (x0 - 0.05, HEIGHT - 0.2, z - 0.075), (x1 + 0.05, HEIGHT + 0.05, z + 0.075), 0.012
        )
    builder.mesh("beams", beams)


def windows(builder, paint):
    frames, boards = Shape(paint["white"]), Shape(paint["white"])
    x0, x1 = -HALF_X - 0.21, -HALF_X - 0.14  # depth of the frame in the wall
    for centre in WINDOWS:
        a, b = centre - WINDOW_HALF, centre + WINDOW_HALF
        for z0, z1 in (
            (a - 0.02, a + 0.055),
            (b - 0.055, b + 0.02),
            (centre - 0.032, centre + 0.032),
        ):
            frames.box((x0, SILL - 0.02, z0), (x1, LINTEL + 0.02, z1), 0.008)
        for y0, y1 in ((SILL - 0.02, SILL + 0.06), (LINTEL - 0.055, LINTEL + 0.02)):
            frames.box((x0, y0, a - 0.02), (x1, y1, b + 0.02), 0.008)
        for part in (1, 2, 3):
            y = SILL + (LINTEL - SILL) * part / 4.0
            frames.box((x0 + 0.018, y - 0.016, a), (x1 - 0.018, y + 0.016, b))
        boards.box(
            (-HALF_X - 0.16, SILL - 0.005, a - 0.06), (-HALF_X + 0.07, SILL + 0.03, b + 0.06), 0.008
        )
    builder.mesh("window frames", frames)
    builder.mesh("window boards", boards)


def curtains(builder, paint):
    cloth, rods = Shape(paint["curtain"]), Shape(paint["brass"])
    for centre in WINDOWS:
        for side in (-1, 1):
            inner, outer = centre + side * (WINDOW_HALF - 0.015), centre + side * (
                WINDOW_HALF + 0.2
            )
            # Seen from the room, right runs towards -z.
            z0, z1 = (outer, inner) if side > 0 else (inner, outer)
            rows = []
            for y in (0.12, 0.9, 1.7, 2.5):
                row = []
                for k in range(37):
                    t = k / 36.0
                    fold = math.sin(2.0 * math.pi * 4.5 * t + 0.4 * y + centre)
                    row.append((-HALF_X + 0.10 + 0.032 * fold, y, z0 + (z1 - z0) * t))
                rows.append(row)
            cloth.sheet(rows)
        rod = Shape(paint["brass"]).lathe(
            [
                (0.0, -0.88),
                (0.022, -0.87),
                (0.022, -0.82),
                (0.011, -0.82),
                (0.011, 0.82),
                (0.022, 0.82),
                (0.022, 0.87),
                (0.0, 0.88),
            ],
            12,
        )
        rods.join(rod, lambda p, c=centre: (-HALF_X + 0.10 + p[0], 2.52 - p[2], c + p[1]))
    builder.mesh("curtains", cloth)
    builder.mesh("curtain rods", rods)


# ---- furniture ----

TABLE_AT, TABLE_TURN = (-0.55, 0.0, -0.15), math.radians(8.0)


def table(builder, paint):
    top = Shape(paint["boards"], uv_scale=1.0 / 1.6).box(
        (-0.85, 0.715, -0.45), (0.85, 0.75, 0.45), 0.006
    )
    frame = Shape(paint["oak"])
    for x in (-0.76, 0.76):
        for z in (-0.36, 0.36):
            frame.box((x - 0.035, 0.0, z - 0.035), (x + 0.035, 0.72, z + 0.035), 0.006)
    for z in (-0.36, 0.36):
        frame.box((-0.74, 0.62, z - 0.014), (0.74, 0.716, z + 0.014))
    for x in (-0.76, 0.76):
        frame.box((x - 0.014, 0.62, -0.34), (x + 0.014, 0.716, 0.34))
    move = placed(*TABLE_AT, TABLE_TURN)
    builder.mesh(
        "table", Shape(paint["boards"]).join(top, move), Shape(paint["oak"]).join(frame, move)
    )


def chair_shape(material):
    """Faces +z, the back at -z."""
    chair = Shape(material)
    chair.box((-0.22, 0.435, -0.20), (0.22, 0.465, 0.23), 0.010)
    for x in (-0.185, 0.185):
        chair.box((x - 0.018, 0.0, 0.17), (x + 0.018, 0.44, 0.206), 0.005)
        chair.box((x - 0.018, 0.0, -0.215), (x + 0.018, 0.93, -0.179), 0.005)
        chair.box((x - 0.010, 0.20, -0.19), (x + 0.010, 0.225, 0.18))
    for y in (0.56, 0.87):
        chair.box((-0.19, y, -0.208), (0.19, y + 0.055, -0.186), 0.005)
    for x in (-0.11, -0.037, 0.037, 0.11):
        chair.box((x - 0.013, 0.60, -0.204), (x + 0.013, 0.88, -0.190))
    chair.box((-0.18, 0.38, 0.176), (0.18, 0.437, 0.20))
    return chair


def chairs(builder, paint):
    shape = Shape(paint["oak"])
    on_table = placed(*TABLE_AT, TABLE_TURN)
    for x, z, turn in (
        (-0.38, -0.52, 0.0),
        (0.40, -0.56, -6.0),
        (-0.42, 0.55, 176.0),
        (0.46, 0.74, 150.0),
    ):
        stand = placed(x, 0.0, z, math.radians(turn))
        shape.join(chair_shape(paint["oak"]), lambda p, stand=stand: on_table(stand(p)))
    builder.mesh("chairs", shape)


def on_table(builder, paint):
    move = placed(TABLE_AT[0], 0.75, TABLE_AT[2], TABLE_TURN)
    vase = Shape(paint["glaze"]).lathe(
        [
            (0.0, 0.0),
            (0.045, 0.0),
            (0.075, 0.06),
            (0.082, 0.12),
            (0.06, 0.19),
            (0.032, 0.235),
            (0.038, 0.265),
            (0.032, 0.265),
            (0.027, 0.235),
            (0.0, 0.22),
        ],
        32,
    )
    builder.mesh(
        "vase", Shape(paint["glaze"]).join(vase, lambda p: move(add(p, (0.22, 0.0, -0.05))))
    )

    rng = random.Random(4)
    twigs, leaves = Shape(paint["dark oak"]), Shape(paint["leaf"])
    for _ in range(9):
        turn, lean = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(0.08, 0.22)
        foot = (0.22, 0.22, -0.05)
        tip = add(foot, (lean * math.cos(turn), rng.uniform(0.26, 0.42), lean * math.sin(turn)))
        stalk(twigs, foot, tip, 0.0025)
        for k in range(6):
            t = 0.35 + 0.65 * k / 5.0
            leaf(
                leaves,
                add(foot, scale(add(tip, scale(foot, -1.0)), t)),
                rng.uniform(0.0, 2.0 * math.pi),
                rng.uniform(-0.2, 0.9),
                0.075,
            )
    builder.mesh(
        "branches",
        Shape(paint["dark oak"]).join(twigs, move),
        Shape(paint["leaf"]).join(leaves, move),
    )

    bowl = Shape(paint["white"]).lathe(
        [
            (0.0, 0.0),
            (0.06, 0.0),
            (0.075, 0.012),
            (0.13, 0.06),
            (0.15, 0.085),
            (0.142, 0.085),
            (0.12, 0.06),
            (0.06, 0.022),
            (0.0, 0.02),
        ],
        32,
    )
    builder.mesh(
        "bowl", Shape(paint["white"]).join(bowl, lambda p: move(add(p, (-0.32, 0.0, 0.06))))
    )
    for name, spots in (
        ("orange", ((-0.36, 0.068, 0.03), (-0.285, 0.068, 0.03), (-0.32, 0.068, 0.105))),
        ("apple", ((-0.325, 0.127, 0.055),)),
    ):
        fruit = Shape(paint[name])
        for spot in spots:
            fruit.join(icosphere(paint[name], spot, 0.041, 2))
        builder.mesh(name, Shape(paint[name]).join(fruit, move))

    book = Shape(paint["book 2"]).box((0.0, 0.0, 0.0), (0.16, 0.025, 0.22), 0.002)
    builder.mesh(
        "open table book",
        Shape(paint["book 2"]).join(book, lambda p: move(placed(0.50, 0.0, 0.08, 0.5)(p))),
    )


def stalk(shape, foot, tip, radius):
    """A three-sided stick."""
    ring = [(radius * math.cos(a), 0.0, radius * math.sin(a)) for a in (0.0, -2.094, -4.189)]
    for k in range(3):
        a, b = ring[k], ring[(k + 1) % 3]
        shape.face([add(foot, a), add(foot, b), add(tip, b), add(tip, a)])


def leaf(shape, foot, turn, lift, length):
    """Two triangles folded along the middle rib."""
    out = (math.cos(turn) * math.cos(lift), math.sin(lift), math.sin(turn) * math.cos(lift))
    side = (-math.sin(turn), 0.0, math.cos(turn))
    tip = add(foot, scale(out, length))
    middle = add(foot, scale(out, 0.45 * length))
    for sign in (1.0, -1.0):
        edge = add(add(middle, scale(side, sign * 0.24 * length)), (0.0, 0.06 * length, 0.0))
        corners = [foot, edge, tip]
        shape.face(corners if sign < 0 else corners[::-1])


def sofa(builder, paint):
    body, pillows = Shape(paint["sofa"]), Shape(paint["cushion"])
    body.box((-1.05, 0.10, -0.42), (1.05, 0.30, 0.42), 0.03)
    for x in (-0.52, 0.52):
        body.box((x - 0.44, 0.28, -0.26), (x + 0.44, 0.45, 0.44), 0.05)
        body.box((x - 0.44, 0.42, -0.30), (x + 0.44, 0.82, -0.12), 0.06)
    for x in (-1.05, 1.05):
        body.box((x - 0.10, 0.10, -0.44), (x + 0.10, 0.60, 0.44), 0.05)
    body.box((-1.05, 0.10, -0.46), (1.05, 0.74, -0.27), 0.04)
    for x, turn, tilt in ((-0.74, 0.25, 0.42), (0.70, -0.3, 0.38)):
        pillow = Shape(paint["cushion"]).box((-0.21, 0.0, -0.06), (0.21, 0.40, 0.06), 0.055)
        c, s = math.cos(tilt), math.sin(tilt)
        stand = placed(x, 0.45, 0.05, turn)
        pillows.join(
            pillow,
            lambda p, c=c, s=s, stand=stand: stand(
                (p[0], c * p[1] + s * p[2], c * p[2] - s * p[1])
            ),
        )
    feet = Shape(paint["dark oak"])
    for x in (-0.95, 0.95):
        for z in (-0.34, 0.34):
            feet.box((x - 0.03, 0.0, z - 0.03), (x + 0.03, 0.12, z + 0.03))
    move = placed(-1.55, 0.0, -2.27)
    builder.mesh("sofa", *(Shape(part.material).join(part, move) for part in (body, pillows, feet)))


def bookcase(builder, paint):
    x0, x1, z0, z1 = 0.45, 1.55, -HALF_Z + 0.01, -HALF_Z + 0.33
    case = Shape(paint["oak"])
    case.box((x0, 0.0, z0), (x0 + 0.03, 2.05, z1), 0.004)
    case.box((x1 - 0.03, 0.0, z0), (x1, 2.05, z1), 0.004)
    case.box((x0 - 0.015, 2.03, z0), (x1 + 0.015, 2.07, z1 + 0.015), 0.006)
    case.box((x0 + 0.01, 0.05, z0), (x1 - 0.01, 2.04, z0 + 0.015))
    shelves = (0.06, 0.46, 0.84, 1.22, 1.62)
    for y in shelves:
        case.box((x0 + 0.01, y, z0), (x1 - 0.01, y + 0.026, z1 - 0.005))
    builder.mesh("bookcase", case)

    rng = random.Random(11)
    colors = [Shape(paint["book %d" % k]) for k in range(6)]
    for y in shelves:
        x = x0 + 0.04
        while x < x1 - 0.09:
            if rng.random() < 0.07:
                x += rng.uniform(0.05, 0.16)
                continue
            width, height = rng.uniform(0.018, 0.05), rng.uniform(0.20, 0.30)
            depth = rng.uniform(0.16, 0.22)
            if x + width > x1 - 0.035:
                break
            rng.choice(colors).box(
                (x, y + 0.024, z1 - 0.03 - depth), (x + width, y + 0.026 + height, z1 - 0.03), 0.003
            )
            x += width + 0.0015
    builder.mesh("books", *colors)


def pictures(builder, paint):
    for k, (x, y, half_w, half_h) in enumerate(
        ((-2.15, 1.62, 0.30, 0.36), (-1.35, 1.66, 0.38, 0.30), (-0.62, 1.58, 0.22, 0.27))
    ):
        z = -HALF_Z
        frame, canvas = Shape(paint["brass" if k == 1 else "dark oak"]), Shape(paint["painting"])
        w, h, b = half_w, half_h, 0.035
        for x0, x1, y0, y1 in (
            (-w - b, w + b, h, h + b),
            (-w - b, w + b, -h - b, -h),
            (-w - b, -w, -h, h),
            (w, w + b, -h, h),
        ):
            frame.box((x + x0, y + y0, z - 0.005), (x + x1, y + y1, z + 0.03), 0.006)
        u0 = 0.0 if k == 1 else 0.3 * k
        canvas.face(
            [
                (x - w, y - h, z + 0.012),
                (x + w, y - h, z + 0.012),
                (x + w, y + h, z + 0.012),
                (x - w, y + h, z + 0.012),
            ],
            [(u0, 1.0), (u0 + w / 0.38, 1.0), (u0 + w / 0.38, 0.0), (u0, 0.0)],
        )
        builder.mesh("picture %d" % (k + 1), frame, canvas)


def rug(builder, paint):
    shape = Shape(paint["rug"])
    move = placed(-0.5, 0.0, -0.2, math.radians(4.0))
    top = 0.012
    corners = [(-1.6, top, 1.0), (1.6, top, 1.0), (1.6, top, -1.0), (-1.6, top, -1.0)]
    shape.face([move(p) for p in corners], [(0, 1), (1, 1), (1, 0), (0, 0)])
    for a, b in zip(corners, corners[1:] + corners[:1]):
        shape.face([move(p) for p in ((a[0], 0.0, a[2]), (b[0], 0.0, b[2]), b, a)], [(0, 0.01)] * 4)
    builder.mesh("rug", shape)


LAMP_AT, LAMP_RADIUS = (-0.5, 1.66, -0.2), 0.125


def lamp(builder, paint):
    shade = Shape(paint["shade"]).lathe(
        [(0.235, -0.03), (0.205, 0.06), (0.13, 0.15), (0.045, 0.19), (0.028, 0.25)], 40
    )
    bowl = Shape(paint["socket"]).lathe(
        [(0.0, 0.012), (LAMP_RADIUS + 0.004, 0.012), (0.05, 0.12), (0.0, 0.13)], 24
    )
    cord = Shape(paint["dark oak"]).lathe([(0.004, 0.24), (0.004, HEIGHT - LAMP_AT[1])], 6)
    cord.lathe(
        [
            (0.0, HEIGHT - LAMP_AT[1] - 0.03),
            (0.05, HEIGHT - LAMP_AT[1] - 0.03),
            (0.05, HEIGHT - LAMP_AT[1] + 0.01),
        ],
        16,
    )
    move = placed(*LAMP_AT)
    builder.mesh("lamp", *(Shape(part.material).join(part, move) for part in (shade, bowl, cord)))


def plant(builder, paint):
    pot = Shape(paint["terracotta"]).lathe(
        [
            (0.0, 0.0),
            (0.13, 0.0),
            (0.17, 0.28),
            (0.185, 0.28),
            (0.185, 0.33),
            (0.165, 0.33),
            (0.155, 0.29),
            (0.0, 0.28),
        ],
        28,
    )
    rng = random.Random(21)
    twigs, leaves = Shape(paint["dark oak"]), Shape(paint["leaf"])
    for _ in range(16):
        turn, lean = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(0.05, 0.36)
        foot = (0.06 * math.cos(turn), 0.28, 0.06 * math.sin(turn))
        tip = (lean * math.cos(turn), rng.uniform(0.75, 1.35), lean * math.sin(turn))
        stalk(twigs, foot, tip, 0.006)
        for k in range(7):
            t = 0.4 + 0.6 * k / 6.0
            leaf(
                leaves,
                add(foot, scale(add(tip, scale(foot, -1.0)), t)),
                turn + rng.uniform(-1.6, 1.6),
                rng.uniform(-0.5, 0.7),
                rng.uniform(0.16, 0.24),
            )
    move = placed(2.15, 0.0, -2.2)
    builder.mesh("plant", *(Shape(part.material).join(part, move) for part in (pot, twigs, leaves)))


def garden(builder, paint):
    ground = Shape(paint["grass"])
    ground.face(
        [(-60.0, -0.4, 60.0), (60.0, -0.4, 60.0), (60.0, -0.4, -60.0), (-60.0, -0.4, -60.0)]
    )
    builder.mesh("ground", ground)
    rng = random.Random(7)
    trees = Shape(paint["tree"])
    # No tree is high enough to shade the windows: 12 m away the sun passes 0.7 + 0.6 * 12 m up.
    for _ in range(14):
        x, z = rng.uniform(-26.0, -13.0), rng.uniform(-24.0, 9.0)
        size = rng.uniform(1.1, 1.75)
        trees.join(
            blob(
                paint["tree"],
                (x, 0.8 * size - 0.4, z),
                (size, 1.1 * size, size),
                lambda p, x=x, z=z: (
                    1.0
                    + 0.22 * math.sin(5.0 * p[0] + z) * math.sin(6.0 * p[1] + x)
                    + rng.uniform(-0.07, 0.07)
                ),
            )
        )
    builder.mesh("trees", trees)


def sidecar():
    circle = [2.0 * math.pi * k / 16 for k in range(16)]
    x, y, z = LAMP_AT
    # Counter-clockwise seen from below, the side it shines to.
    disc = [
        [round(x + LAMP_RADIUS * math.cos(a), 6), y, round(z + LAMP_RADIUS * math.sin(a), 6)]
        for a in circle
    ]
    margin = 0.2  # into the walls
    return {
        "media": [
            {
                "name": "haze",
                **HAZE,
                "boundary": {
                    "box": {
                        "min": [-HALF_X - margin, -margin, -HALF_Z - margin],
                        "max": [HALF_X + margin, HEIGHT + margin, HALF_Z + margin],
                    }
                },
            }
        ],
        "lights": [
            {
                "name": "sun",
                "type": "collimated",
                "direction": SUN_TRAVELS,
                "irradiance": SUN_IRRADIANCE,
            },
            {"name": "lamp", "type": "polygon", "vertices": disc, "radiance": LAMP_RADIANCE},
            {"name": "sky", "type": "environment", "radiance": SKY_RADIANCE},
        ],
    }


def materials(builder):
    planks = builder.texture("planks.png")
    paint = {
        "plaster": builder.material("plaster", (0.40, 0.46, 0.44), specular=0.0),
        "ceiling": builder.material("ceiling", (0.58, 0.56, 0.52), specular=0.0),
        "planks": builder.material("planks", (0.85, 0.85, 0.85), roughness=0.42, texture=planks),
        "boards": builder.material("boards", (1.0, 0.92, 0.85), roughness=0.38, texture=planks),
        "oak": builder.material("oak", (0.36, 0.20, 0.095), roughness=0.5),
        "dark oak": builder.material("dark oak", (0.15, 0.085, 0.045), roughness=0.65),
        "white": builder.material("white paint", (0.80, 0.79, 0.75), roughness=0.45),
        "curtain": builder.material("curtain", (0.72, 0.64, 0.48), specular=0.0, double_sided=True),
        "brass": builder.material("brass", (0.85, 0.62, 0.32), roughness=0.35, metallic=1.0),
        "glaze": builder.material("glaze", (0.05, 0.16, 0.24), roughness=0.22),
        "leaf": builder.material("leaf", (0.09, 0.20, 0.05), roughness=0.6, double_sided=True),
        "terracotta": builder.material("terracotta", (0.48, 0.19, 0.10), specular=0.0),
        "sofa": builder.material("sofa", (0.16, 0.24, 0.27), specular=0.0),
        "cushion": builder.material("cushion", (0.60, 0.26, 0.06), specular=0.0),
        "rug": builder.material(
            "rug", (1.0, 1.0, 1.0), specular=0.0, texture=builder.texture("rug.png")
        ),
        "painting": builder.material(
            "painting", (1.0, 1.0, 1.0), specular=0.0, texture=builder.texture("painting.png")
        ),
        "shade": builder.material(
            "lampshade", (0.10, 0.20, 0.16), roughness=0.5, double_sided=True
        ),
        "socket": builder.material("socket", (0.75, 0.72, 0.66), specular=0.0),
        "orange": builder.material("orange", (0.75, 0.28, 0.03), roughness=0.5),
        "apple": builder.material("apple", (0.50, 0.05, 0.03), roughness=0.35),
        "grass": builder.material("grass", (0.16, 0.20, 0.08), specular=0.0),
        "tree": builder.material("tree", (0.06, 0.12, 0.03), specular=0.0),
    }
    for k, color in enumerate(
        (
            (0.35, 0.07, 0.05),
            (0.06, 0.14, 0.25),
            (0.10, 0.22, 0.12),
            (0.55, 0.42, 0.22),
            (0.62, 0.57, 0.48),
            (0.12, 0.10, 0.10),
        )
    ):
        paint["book %d" % k] = builder.material("book %d" % k, color, roughness=0.7)
    return paint


def main():
    write_planks(os.path.join(FOLDER, "planks.png"))
    write_rug(os.path.join(FOLDER, "rug.png"))
    write_painting(os.path.join(FOLDER, "painting.png"))
    builder = Builder("sunroom")
    paint = materials(builder)
    for part in (
        walls,
        windows,
        curtains,
        table,
        chairs,
        on_table,
        sofa,
        bookcase,
        pictures,
        rug,
        lamp,
        plant,
        garden,
    ):
        part(builder, paint)
    builder.camera("camera", (2.95, 1.42, 1.0), (-1.5, 1.12, -0.85), math.radians(48.0), 16.0 / 9.0)
    builder.write(FOLDER, "sunroom")
    write_json(os.path.join(FOLDER, "sunroom.airlight.json"), sidecar())


main()
