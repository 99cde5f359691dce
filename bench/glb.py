"""Reads and writes binary glTF: the scene's JSON, and the rest of the file as it is."""

import json
import struct


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    (size,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + size]), data[20 + size :]


def write(path, scene, rest):
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + rest)
