#!/usr/bin/env python3
"""Packs the runs of zeros of an unpacked .nvdb file for fuzz_nvdb.c: pack_nvdb.py IN.nvdb OUT

Files with the zip codec and one grid are unpacked first.
"""
import struct
import sys
import zlib

HEADER, DESCRIPTION = 16, 176


def unpack(data):
    """The same file with codec none."""
    if struct.unpack_from("<H", data, 14)[0] != 1:
        return data
    name_size = struct.unpack_from("<I", data, HEADER + 136)[0]
    start = HEADER + DESCRIPTION + name_size
    grid = zlib.decompress(data[start + 8:])
    out = bytearray(data[:start] + grid)
    struct.pack_into("<H", out, 14, 0)
    struct.pack_into("<Q", out, HEADER + 8, len(grid))
    return bytes(out)


def pack(data):
    out, at = bytearray(b"P"), 0
    while at < len(data):
        begin = at
        while at < len(data) and data[at] == 0 and at - begin < 0xFFFF:
            at += 1
        zeros, begin = at - begin, at
        # a few zeros inside a literal are shorter than a new run
        while at < len(data) and at - begin < 0xFF and data[at:at + 4] != bytes(4):
            at += 1
        out += struct.pack("<HB", zeros, at - begin) + data[begin:at]
    return bytes(out)


with open(sys.argv[1], "rb") as file:
    packed = pack(unpack(file.read()))
with open(sys.argv[2], "wb") as file:
    file.write(packed)
