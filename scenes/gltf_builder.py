"""Writes glTF 2.0 scenes and their pictures with nothing but Python's standard library.

A Builder collects textures, materials, meshes (see shapes.py) and cameras; Builder.write puts
NAME.gltf and NAME.bin into a folder. Lengths are metres, +Y is up, angles are radians.
"""

import json
import os
import re
import struct
import zlib

from shapes import cross, sub, unit


def look_at(position, target, up=(0.0, 1.0, 0.0)):
    """The glTF node transform of a camera: 16 numbers, column by column."""
    back = unit(sub(position, target))
    right = unit(cross(up, back))
    above = cross(back, right)
    return [*right, 0.0, *above, 0.0, *back, 0.0, *position, 1.0]


def srgb(linear):
    """One channel, encoded for a picture."""
    return 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1.0 / 2.4) - 0.055


def write_png(path, width, height, pixel):
    """An 8-bit sRGB picture; pixel(x, y) gives linear red, green and blue in [0, 1]."""
    rows = bytearray()
    for y in range(height):
        rows.append(0)
        for x in range(width):
            rows += bytes(round(255.0 * srgb(min(1.0, max(0.0, c)))) for c in pixel(x, y))

    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        file.write(chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)))
        file.write(chunk(b"IDAT", zlib.compress(bytes(rows), 9)))
        file.write(chunk(b"IEND", b""))


def write_json(path, value):
    """Indented, with lists of plain numbers on one line."""
    text = json.dumps(value, indent=2)
    text = re.sub(
        r"\[\s+([-+.\deE,\s]*?)\s+\]", lambda found: "[" + re.sub(r"\s+", " ", found[1]) + "]", text
    )
    with open(path, "w", encoding="utf-8") as file:
        file.write(text + "\n")


class Builder:
    def __init__(self, title):
        self.data = bytearray()
        self.gltf = {
            "asset": {"version": "2.0", "generator": "airlight scenes", "extras": {"title": title}},
            "extensionsUsed": ["KHR_materials_specular"],
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "cameras": [],
            "meshes": [],
            "materials": [],
            "accessors": [],
            "bufferViews": [],
            "buffers": [],
        }

    def texture(self, uri):
        images = self.gltf.setdefault("images", [])
        textures = self.gltf.setdefault("textures", [])
        images.append({"uri": uri})
        textures.append({"source": len(images) - 1})
        return len(textures) - 1

    def material(
        self,
        name,
        color,
        roughness=1.0,
        metallic=0.0,
        specular=1.0,
        texture=None,
        double_sided=False,
    ):
        """color is linear. specular 0 with metallic 0 is a pure Lambert surface."""
        pbr = {
            "baseColorFactor": [*color, 1.0],
            "metallicFactor": metallic,
            "roughnessFactor": roughness,
        }
        if texture is not None:
            pbr["baseColorTexture"] = {"index": texture}
        material = {"name": name, "pbrMetallicRoughness": pbr}
        if specular != 1.0:
            material["extensions"] = {"KHR_materials_specular": {"specularFactor": specular}}
        if double_sided:
            material["doubleSided"] = True
        self.gltf["materials"].append(material)
        return len(self.gltf["materials"]) - 1

    def camera(self, name, position, target, yfov, aspect):
        self.gltf["cameras"].append(
            {
                "name": name,
                "type": "perspective",
                "perspective": {"aspectRatio": aspect, "yfov": yfov, "znear": 0.01},
            }
        )
        self._node(
            {
                "name": name,
                "camera": len(self.gltf["cameras"]) - 1,
                "matrix": look_at(position, target),
            }
        )

    def mesh(self, name, *shapes):
        """One mesh with a primitive for each shape."""
        primitives = []
        for shape in shapes:
            material = self.gltf["materials"][shape.material]
            attributes = {
                "POSITION": self._accessor(shape.positions, "VEC3", bounds=True),
                "NORMAL": self._accessor(shape.normals, "VEC3"),
            }
            if "baseColorTexture" in material["pbrMetallicRoughness"]:
                attributes["TEXCOORD_0"] = self._accessor(shape.uvs, "VEC2")
            primitives.append(
                {
                    "attributes": attributes,
                    "material": shape.material,
                    "indices": self._indices(shape.indices, len(shape.positions)),
                }
            )
        self.gltf["meshes"].append({"name": name, "primitives": primitives})
        self._node({"name": name, "mesh": len(self.gltf["meshes"]) - 1})

    def write(self, folder, name):
        self.gltf["buffers"] = [{"uri": name + ".bin", "byteLength": len(self.data)}]
        with open(os.path.join(folder, name + ".bin"), "wb") as file:
            file.write(self.data)
        write_json(os.path.join(folder, name + ".gltf"), self.gltf)

    def _node(self, node):
        self.gltf["nodes"].append(node)
        self.gltf["scenes"][0]["nodes"].append(len(self.gltf["nodes"]) - 1)

    def _view(self, data, target):
        self.data += bytes(-len(self.data) % 4)
        self.gltf["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), "target": target}
        )
        self.data += data
        return len(self.gltf["bufferViews"]) - 1

    def _accessor(self, rows, kind, bounds=False):
        flat = [x for row in rows for x in row]
        data = struct.pack("<%df" % len(flat), *flat)
        accessor = {
            "bufferView": self._view(data, 34962),
            "componentType": 5126,
            "count": len(rows),
            "type": kind,
        }
        if bounds:
            stored = struct.unpack("<%df" % len(flat), data)
            accessor["min"] = [min(stored[k::3]) for k in range(3)]
            accessor["max"] = [max(stored[k::3]) for k in range(3)]
        self.gltf["accessors"].append(accessor)
        return len(self.gltf["accessors"]) - 1

    def _indices(self, indices, vertex_count):
        code, component = ("H", 5123) if vertex_count < 65536 else ("I", 5125)
        data = struct.pack("<%d%s" % (len(indices), code), *indices)
        self.gltf["accessors"].append(
            {
                "bufferView": self._view(data, 34963),
                "componentType": component,
                "count": len(indices),
                "type": "SCALAR",
            }
        )
        return len(self.gltf["accessors"]) - 1
