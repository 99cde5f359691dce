"""Scenes of media under photographed skies, for ordinates_figures.py: smoke and a torus made by others
(../shared), a block of milk and a cloud of our own. Lengths are metres, +Y is up."""

import json
import math
import os
import struct
import subprocess

import numpy as np

SKIES = {"indoors": "vestibule_1k", "noon": "noon_grass_1k"}


def look_at(eye, at):
    """A camera's matrix, column by column."""
    eye, at = np.array(eye, float), np.array(at, float)
    back = (eye - at) / np.linalg.norm(eye - at)
    right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    return [float(x) for x in (*right, 0, *up, 0, *back, 0, *eye, 1)]


def write_scene(folder, name, camera, medium, sky):
    """NAME.gltf with nothing but a camera, and its sidecar."""
    eye, at, fov = camera
    perspective = {"yfov": math.radians(fov), "aspectRatio": 4 / 3, "znear": 0.01}
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"camera": 0, "matrix": look_at(eye, at)}],
        "cameras": [{"type": "perspective", "perspective": perspective}],
    }
    light = {"name": "sky", "type": "environment", "image": sky}
    path = os.path.join(folder, name + ".gltf")
    with open(path, "w") as file:
        json.dump(scene, file)
    with open(os.path.join(folder, name + ".airlight.json"), "w") as file:
        json.dump({"media": [medium], "lights": [light]}, file)
    return path


def smoke(shared):
    grid = {"grid": {"file": os.path.join(shared, "lajolla_volpath", "smoke.vol")}}
    return {"name": "smoke", "sigma_s": 90.0, "sigma_a": 10.0, "g": 0.5, "density": grid}


def torus(shared, folder, airlight):
    """torus01.vdb as .nvdb, of densities up to 100, 16 m across; None where the converter was not
    built."""
    out = os.path.join(folder, "torus.nvdb")
    source = os.path.join(shared, "vdb", "torus01.vdb")
    done = subprocess.run([airlight, "convert", source, out, "-q"], stderr=subprocess.DEVNULL)
    if done.returncode != 0:
        return None
    grid = {"grid": {"file": out, "name": "voxel_fog_density"}}
    return {"name": "torus", "sigma_s": 0.03, "sigma_a": 0.0003, "g": 0.5, "density": grid}


def milk():
    box = {"box": {"min": [-0.5, -0.5, -0.5], "max": [0.5, 0.5, 0.5]}}
    return {
        "name": "milk",
        "sigma_s": 30.0,
        "sigma_a": [0.01, 0.015, 0.025],
        "g": 0.8,
        "boundary": box,
    }


def cloud(folder, size=64):
    """Balls with soft rims and noise in a .vol file."""
    random = np.random.RandomState(5)
    axis = (np.arange(size) + 0.5) / size - 0.5
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    density = np.zeros_like(x)
    for _ in range(26):
        cx, cy, cz = random.uniform((-0.28, -0.16, -0.28), (0.28, 0.16, 0.28))
        radius = random.uniform(0.08, 0.17)
        distance = np.sqrt((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2)
        density = np.maximum(density, np.clip(1.3 - distance / radius, 0.0, 1.0))
    noise = np.kron(random.rand(16, 16, 16), np.ones((4, 4, 4)))
    for along in range(3):
        shifts = [np.roll(noise, n, along) for n in (-2, -1, 0, 1, 2)]
        noise = sum(shifts) / 5.0
    density = np.clip(density * (0.6 + 1.6 * (noise - 0.3)), 0.0, 1.0)
    header = struct.pack(
        "<3sbiiiiiffffff", b"VOL", 3, 1, size, size, size, 1, -0.5, -0.5, -0.5, 0.5, 0.5, 0.5
    )
    with open(os.path.join(folder, "cloud.vol"), "wb") as file:
        file.write(header + density.astype("<f4").tobytes())
    grid = {"grid": {"file": "cloud.vol"}}
    return {"name": "cloud", "sigma_s": 60.0, "sigma_a": 0.05, "g": 0.96, "density": grid}


def write_all(folder, shared, airlight):
    """{name: path} of all scenes that can be made."""
    media = {
        "smoke": (((0.0, 0.15, 1.5), (0.0, 0.0, 0.0), 38.0), smoke(shared)),
        "torus": (((-8.0, 9.0, 25.0), (-8.0, -1.6, 3.2), 38.0), torus(shared, folder, airlight)),
        "milk": (((1.2, 0.9, 2.0), (0.0, 0.0, 0.0), 35.0), milk()),
        "cloud": (((0.4, 0.2, 1.9), (0.0, 0.0, 0.0), 35.0), cloud(folder)),
    }
    scenes = {}
    for name, (camera, medium) in media.items():
        for sky, file in SKIES.items():
            if medium is not None:
                image = os.path.join(shared, "hdr", file + ".hdr")
                title = f"{name}-{sky}"
                scenes[title] = write_scene(folder, title, camera, medium, image)
    return scenes
