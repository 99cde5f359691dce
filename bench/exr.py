"""Reads the scanline OpenEXR files that airlight writes (no compression, ZIPS or ZIP; 16-bit and
32-bit floats), and writes such files, with NumPy."""

import struct
import zlib

import numpy as np

LINES = {0: 1, 2: 1, 3: 16}  # of a block, by compression
TYPES = {1: "<f2", 2: "<f4"}


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _header(data):
    """Attributes by name, and where the table of offsets begins."""
    attributes, at = {}, 8
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _channels(data):
    """Names and types, in the order of the file."""
    found, at = [], 0
    while data[at]:
        name, at = _text(data, at)
        found.append((name, TYPES[struct.unpack_from("<i", data, at)[0]]))
        at += 16
    return found


def _unzip(block, size):
    if len(block) == size:
        return block
    raw = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.uint64)
    raw[1:] += 128
    raw = np.cumsum(raw).astype(np.uint8)
    out = np.empty_like(raw)
    half = (len(raw) + 1) // 2
    out[0::2], out[1::2] = raw[:half], raw[half:]
    return out.tobytes()


def read(path):
    """{channel: array of height x width in double precision}; row 0 is the top."""
    with open(path, "rb") as file:
        data = file.read()
    attributes, table = _header(data)
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = _channels(attributes["channels"])
    lines = LINES[attributes["compression"][0]]
    out = {name: np.empty((height, width)) for name, _ in channels}
    for block in range((height + lines - 1) // lines):
        (at,) = struct.unpack_from("<Q", data, table + 8 * block)
        y, size = struct.unpack_from("<ii", data, at)
        rows = range(y - y0, min(y - y0 + lines, height))
        row_size = width * sum(np.dtype(kind).itemsize for _, kind in channels)
        pixels, used = _unzip(data[at + 8 : at + 8 + size], row_size * len(rows)), 0
        for row in rows:
            for name, kind in channels:
                out[name][row] = np.frombuffer(pixels, kind, width, used)
                used += width * np.dtype(kind).itemsize
    return out


def colour(channels, layer=""):
    """height x width x 3 of a layer, "" being the sum of them all."""
    prefix = layer + "." if layer else ""
    return np.stack([channels[prefix + name] for name in "RGB"], -1)


def write(path, channels):
    """Writes arrays of height x width as 32-bit floats, not compressed."""
    names = sorted(channels)
    height, width = channels[names[0]].shape
    listed = b"".join(n.encode() + struct.pack("<xiiii", 2, 0, 1, 1) for n in names) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    attributes = [
        ("channels", "chlist", listed),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
    ]
    header = struct.pack("<4sI", b"\x76\x2f\x31\x01", 2)
    for name, kind, value in attributes:
        header += name.encode() + b"\0" + kind.encode() + b"\0"
        header += struct.pack("<i", len(value)) + value
    header += b"\0"
    rows = np.stack([channels[n] for n in names], 1).astype("<f4")  # row, channel, column
    size = 4 * width * len(names)
    first = len(header) + 8 * height
    with open(path, "wb") as file:
        file.write(header)
        file.write(struct.pack(f"<{height}Q", *(first + (8 + size) * y for y in range(height))))
        for y in range(height):
            file.write(struct.pack("<ii", y, size) + rows[y].tobytes())
