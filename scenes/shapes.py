"""Vectors and triangles for the scenes beside it, with nothing but Python's standard library.

Lengths are metres, +Y is up, angles are radians. Texture coordinates are metres times
Shape.uv_scale.
"""

import math

# ---- small vectors ----


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return scale(a, 1.0 / math.sqrt(dot(a, a)))


# ---- triangles ----


class Shape:
    """Triangles with normals and texture coordinates, all of one material."""

    def __init__(self, material, uv_scale=1.0):
        self.material = material
        self.uv_scale = uv_scale
        self.positions, self.normals, self.uvs, self.indices = [], [], [], []

    def vertex(self, position, normal, uv=(0.0, 0.0)):
        self.positions.append(position)
        self.normals.append(normal)
        self.uvs.append((uv[0] * self.uv_scale, uv[1] * self.uv_scale))
        return len(self.positions) - 1

    def face(self, corners, uvs=None):
        """A convex polygon, counter-clockwise seen from the front. Without uvs the texture lies
        in the two axes that the face is most parallel to."""
        normal = unit(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0])))
        if uvs is None:
            axis = max(range(3), key=lambda k: abs(normal[k]))
            u, v = ((2, 1), (0, 2), (0, 1))[axis]
            uvs = [(p[u], p[v]) for p in corners]
        first = [self.vertex(p, normal, uv) for p, uv in zip(corners, uvs)]
        for k in range(2, len(first)):
            self.indices += [first[0], first[k - 1], first[k]]

    def box(self, low, high, bevel=0.0):
        """A closed box between two corners; a bevel cuts all its edges at 45 degrees."""

        def corner(signs, inset):
            return tuple(
                (high[k] - inset[k] if signs[k] > 0 else low[k] + inset[k]) for k in range(3)
            )

        signs = (-1, 1)
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            inset = [bevel] * 3
            inset[axis] = 0.0
            for side in signs:
                ring = []
                for su, sv in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                    at = [side] * 3
                    at[u], at[v] = su, sv
                    ring.append(corner(at, inset))
                self.face(ring if side > 0 else ring[::-1])
        if bevel > 0.0:
            self._bevels(corner, bevel)
        return self

    def _bevels(self, corner, bevel):
        for axis in range(3):  # edges along this axis, between the faces of the two others
            u, v = (axis + 1) % 3, (axis + 2) % 3
            on_u, on_v = [bevel] * 3, [bevel] * 3
            on_u[u], on_v[v] = 0.0, 0.0
            for su in (-1, 1):
                for sv in (-1, 1):
                    ends = []
                    for end in (-1, 1):
                        at = [end] * 3
                        at[u], at[v] = su, sv
                        ends.append(at)
                    ring = [
                        corner(ends[0], on_u),
                        corner(ends[1], on_u),
                        corner(ends[1], on_v),
                        corner(ends[0], on_v),
                    ]
                    self.face(ring if su * sv < 0 else ring[::-1])
        for sx in (-1, 1):
            for sy in (-1, 1):
                for sz in (-1, 1):
                    ring = []
                    for axis in range(3):
                        inset = [bevel] * 3
                        inset[axis] = 0.0
                        ring.append(corner((sx, sy, sz), inset))
                    self.face(ring if sx * sy * sz > 0 else ring[::-1])

    def lathe(self, profile, segments=24, centre=(0.0, 0.0, 0.0), crease=math.radians(35.0)):
        """Turns (radius, height) points about a vertical axis; seen from outside the profile runs
        upwards. Normals are smooth where the profile bends by less than `crease`."""
        slopes = [math.atan2(q[1] - p[1], q[0] - p[0]) for p, q in zip(profile, profile[1:])]

        def slope_at(piece, end):
            near = piece + (1 if end else -1)
            if 0 <= near < len(slopes) and abs(slopes[near] - slopes[piece]) < crease:
                return 0.5 * (slopes[near] + slopes[piece])
            return slopes[piece]

        for piece, (p, q) in enumerate(zip(profile, profile[1:])):
            rows = []
            for (radius, height), end in ((p, 0), (q, 1)):
                slope = slope_at(piece, end)
                row = []
                for k in range(segments + 1):
                    angle = 2.0 * math.pi * (k % segments) / segments
                    c, s = math.cos(angle), -math.sin(angle)
                    row.append(
                        self.vertex(
                            add(centre, (radius * c, height, radius * s)),
                            (math.sin(slope) * c, -math.cos(slope), math.sin(slope) * s),
                        )
                    )
                rows.append(row)
            for k in range(segments):
                b, a, c, d = rows[0][k], rows[0][k + 1], rows[1][k], rows[1][k + 1]
                if p[0] > 0.0:
                    self.indices += [b, a, d]
                if q[0] > 0.0:
                    self.indices += [b, d, c]
        return self

    def sheet(self, rows):
        """A smooth surface through a grid of points, seen from the front when rows run right and
        columns up."""
        grid = []
        height, width = len(rows), len(rows[0])
        for j in range(height):
            line = []
            for i in range(width):
                across = sub(rows[j][min(i + 1, width - 1)], rows[j][max(i - 1, 0)])
                up = sub(rows[min(j + 1, height - 1)][i], rows[max(j - 1, 0)][i])
                line.append(self.vertex(rows[j][i], unit(cross(across, up))))
            grid.append(line)
        for j in range(height - 1):
            for i in range(width - 1):
                a, b, c, d = grid[j][i], grid[j][i + 1], grid[j + 1][i + 1], grid[j + 1][i]
                self.indices += [a, b, c, a, c, d]
        return self

    def smooth(self):
        """Sets each vertex's normal to the mean of its triangles', weighted by area."""
        sums = [(0.0, 0.0, 0.0)] * len(self.positions)
        for k in range(0, len(self.indices), 3):
            ids = self.indices[k : k + 3]
            a, b, c = (self.positions[i] for i in ids)
            normal = cross(sub(b, a), sub(c, a))
            for i in ids:
                sums[i] = add(sums[i], normal)
        self.normals = [unit(n) for n in sums]
        return self

    def join(self, other, move=lambda p: p):
        """Adds another shape's triangles after the rigid motion `move`."""
        first = len(self.positions)
        origin = move((0.0, 0.0, 0.0))
        self.positions += [move(p) for p in other.positions]
        self.normals += [sub(move(n), origin) for n in other.normals]
        self.uvs += other.uvs
        self.indices += [first + i for i in other.indices]
        return self


def placed(x, y, z, turn=0.0):
    """The motion that turns about the vertical axis, then moves to (x, y, z)."""
    c, s = math.cos(turn), math.sin(turn)
    return lambda p: (x + c * p[0] + s * p[2], y + p[1], z - s * p[0] + c * p[2])


def icosphere(material, centre, radius, subdivisions):
    """A sphere of 20 * 4^subdivisions triangles, its vertices on the sphere, normals smooth."""
    golden = (1.0 + math.sqrt(5.0)) / 2.0
    points = [
        unit(p)
        for a, b in ((1, golden), (-1, golden), (1, -golden), (-1, -golden))
        for p in ((0, a, b), (a, b, 0), (b, 0, a))
    ]
    edge = min(dot(sub(p, q), sub(p, q)) for p in points for q in points if p != q)

    def near(i, j):
        return dot(sub(points[i], points[j]), sub(points[i], points[j])) < 1.01 * edge

    faces = []
    for i in range(12):
        for j in range(i + 1, 12):
            for k in range(j + 1, 12):
                if near(i, j) and near(j, k) and near(i, k):
                    outward = dot(points[i], cross(points[j], points[k])) > 0.0
                    faces.append((i, j, k) if outward else (i, k, j))
    for _ in range(subdivisions):
        middles, finer = {}, []

        def middle(i, j):
            key = (min(i, j), max(i, j))
            if key not in middles:
                middles[key] = len(points)
                points.append(unit(add(points[i], points[j])))
            return middles[key]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    shape = Shape(material)
    for p in points:
        shape.vertex(add(centre, scale(p, radius)), p)
    shape.indices = [i for face in faces for i in face]
    return shape


def blob(material, centre, size, bump, subdivisions=2):
    """An icosphere of size (x, y, z) whose points p on the unit sphere move to bump(p) p."""
    shape = icosphere(material, (0.0, 0.0, 0.0), 1.0, subdivisions)
    shape.positions = [
        add(centre, tuple(size[k] * bump(p) * p[k] for k in range(3))) for p in shape.positions
    ]
    return shape.smooth()
