#!/usr/bin/env python3
"""Renders roombeam by airlight and by Mitsuba 3 in turn on this machine, and compares speed and
noise.

    python3 bench/roombeam.py [--airlight PATH] [--repetitions N] [--threads N]

Needs Python's standard library only. Mitsuba takes part if this interpreter can import it (its
LLVM variant too, if it finds an LLVM: DRJIT_LIBLLVM_PATH); what cannot take part is named with
the reason. Printed are

- seconds per sample per pixel at 640 x 480, for single scattering and for up to 32 events: the
  median and the range of the repetitions, the renderers taking turns. Loading and compiling the
  scene are left out: Mitsuba renders once before the clock starts, airlight reports the time that
  rendering took;
- the relative RMSE, sqrt(mean (I - R)^2) / mean R, of the single-scattering picture over its
  fog-only pixels, against the shipped quadrature. The reference belongs to pixel centres and
  airlight renders it with --filter point; Mitsuba has only filters with an area, and even a
  noise-free box-filtered picture is 0.96 % from the reference;
- the time to 2 % relative RMSE: airlight's whole command with as few samples as do it; Mitsuba's
  from its error at 64 samples, which falls with the square root of the number of samples.
"""

import argparse
import array
import importlib.util
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
SCENE = os.path.join(ROOT, "scenes", "roombeam", "roombeam.gltf")
MITSUBA_SCENE = os.path.join(ROOT, "..", "shared", "scenes", "roombeam", "roombeam-mitsuba3.xml")
REFERENCE = os.path.join(ROOT, "tests", "data", "roombeam_reference")
MITSUBA_VARIANTS = ("scalar_rgb", "llvm_ad_rgb")
WIDTH, HEIGHT = 640, 480
SINGLE, MANY = 1, 32  # events
GOAL = 0.02


# ---- pictures ----


def read_pfm(path):
    """The first channel, rows from the top."""
    with open(path, "rb") as file:
        data = file.read()
    kind, size, order, pixels = data.split(b"\n", 3)
    width, height = map(int, size.split())
    channels = {b"PF": 3, b"Pf": 1}[kind]
    values = array.array("f", pixels[: 4 * channels * width * height])
    if (float(order) < 0.0) != (sys.byteorder == "little"):
        values.byteswap()
    rows = [
        values[channels * width * y : channels * width * (y + 1) : channels] for y in range(height)
    ]
    return [value for row in reversed(rows) for value in row]


def read_mask(path):
    """Indices of the pixels that are set in a PBM."""
    with open(path, "rb") as file:
        data = file.read().split(b"\n", 2)[2]
    return [
        8 * i + k for i, byte in enumerate(data) if byte for k in range(8) if byte >> (7 - k) & 1
    ]


class Truth:
    def __init__(self):
        image = read_pfm(REFERENCE + ".pfm")
        self.mask = read_mask(REFERENCE + ".pbm")
        self.values = [image[i] for i in self.mask]
        self.mean = statistics.fmean(self.values)

    def relative_rmse(self, path):
        image = read_pfm(path)
        errors = [(image[i] - value) ** 2 for i, value in zip(self.mask, self.values)]
        return math.sqrt(statistics.fmean(errors)) / self.mean


# ---- renderers ----


class Airlight:
    name = "airlight"

    def __init__(self, command, threads, method="path"):
        self.command, self.threads, self.method = command, threads, method

    def render(self, events, spp, seed, path, box=True):
        """Seconds that rendering took, and the whole command."""
        start = time.perf_counter()
        done = subprocess.run(
            [
                self.command,
                "render",
                SCENE,
                "-o",
                path,
                "--json",
                "-q",
                "-t",
                str(self.threads),
                "--width",
                str(WIDTH),
                "--height",
                str(HEIGHT),
                "--spp",
                str(spp),
                "--seed",
                str(seed),
                "--max-depth",
                str(events),
                "--filter",
                "box" if box else "point",
                "--method",
                self.method,
            ],
            stdout=subprocess.PIPE,
            check=True,
        )
        whole = time.perf_counter() - start
        return json.loads(done.stdout)["seconds"]["render"], whole


class Mitsuba:
    """A process of its own for each variant: it renders on request, its kernels stay compiled."""

    def __init__(self, variant, threads):
        self.name = "mitsuba " + variant
        self.messages = tempfile.TemporaryFile("w+", errors="replace")
        self.process = subprocess.Popen(
            [
                sys.executable,
                os.path.abspath(__file__),
                "--serve",
                variant,
                "--threads",
                str(threads),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.messages,
            text=True,
        )
        self.version = self._reply()["version"]
        self.render(SINGLE, 1, 0, "")  # an LLVM that is too old ends the process only here

    def render(self, events, spp, seed, path, box=True):
        # Its filters all have an area. Its max_depth counts edges of a path: events + 1.
        self.process.stdin.write(json.dumps([events + 1, spp, seed, path]) + "\n")
        self.process.stdin.flush()
        seconds = self._reply()["seconds"]
        return seconds, seconds

    def _reply(self):
        line = self.process.stdout.readline()
        if not line:
            self.messages.seek(0)
            raise RuntimeError(self.messages.readline().strip() or "its process ended")
        return json.loads(line)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def serve(variant, threads):
    """The other end of Mitsuba: answers one line for each request."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what Mitsuba prints shall not mix with the answers
    import drjit
    import mitsuba

    mitsuba.set_variant(variant)
    drjit.set_thread_count(threads)

    def answer(value):
        answers.write(json.dumps(value) + "\n")
        answers.flush()

    answer({"version": mitsuba.__version__})
    scenes = {}
    for line in sys.stdin:
        depth, spp, seed, path = json.loads(line)
        if depth not in scenes:
            scenes[depth] = mitsuba.load_file(MITSUBA_SCENE, depth=depth)
        start = time.perf_counter()
        image = mitsuba.render(scenes[depth], spp=spp, seed=seed)
        drjit.eval(image)
        drjit.sync_thread()
        seconds = time.perf_counter() - start
        if path:
            mitsuba.Bitmap(image).convert(
                mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, False
            ).write(path)
        answer({"seconds": seconds})


def find_airlight(path):
    candidates = (
        [path]
        if path
        else [
            os.path.join(ROOT, "build", "release", "airlight"),
            os.path.join(ROOT, "build", "airlight"),
        ]
    )
    for candidate in candidates:
        if os.access(candidate, os.X_OK):
            return candidate
    sys.exit("no airlight command at " + " or ".join(candidates) + "; name it with --airlight PATH")


def find_peers(threads):
    if not os.path.exists(MITSUBA_SCENE):
        print("mitsuba skipped: no scene at " + os.path.relpath(MITSUBA_SCENE))
        return []
    if importlib.util.find_spec("mitsuba") is None:
        print("mitsuba skipped: %s cannot import it" % os.path.basename(sys.executable))
        return []
    peers = []
    for variant in MITSUBA_VARIANTS:
        try:
            peers.append(Mitsuba(variant, threads))
        except RuntimeError as error:
            print("mitsuba %s skipped: %s" % (variant, error))
    return peers


# ---- measurements ----


def print_speed(renderers, options, folder):
    picture = os.path.join(folder, "speed.pfm")
    for events in (SINGLE, MANY):
        taken = {renderer.name: [] for renderer in renderers}
        for renderer in renderers:
            renderer.render(events, 16, 0, picture)
        for repetition in range(options.repetitions):
            for renderer in renderers:
                seconds, _ = renderer.render(events, options.spp, repetition + 1, picture)
                taken[renderer.name].append(seconds / options.spp)
        print(
            "\nseconds per sample per pixel, %d event%s"
            " (median, lowest, highest of %d with %d samples; ratio)"
            % (events, "s" if events > 1 else "", options.repetitions, options.spp)
        )
        own = statistics.median(taken[renderers[0].name])
        for name, times in taken.items():
            middle = statistics.median(times)
            print(
                "%-22s %8.4f %8.4f %8.4f   %6.2f"
                % (name, middle, min(times), max(times), middle / own)
            )


def print_noise(renderers, options, folder, truth):
    picture = os.path.join(folder, "noise.pfm")
    print(
        "\nrelative RMSE of fog-only pixels, single scattering (root mean square of %d seeds),"
        " and time to %g %%" % (options.repetitions, 100.0 * GOAL)
    )
    for renderer in renderers:
        line = "%-22s" % renderer.name
        for spp in (16, 64):
            squares, seconds = [], 0.0
            for seed in range(options.repetitions):
                seconds = renderer.render(SINGLE, spp, seed, picture, box=False)[1]
                squares.append(truth.relative_rmse(picture) ** 2)
            error = math.sqrt(statistics.fmean(squares))
            line += "  %3d spp %6.2f %%" % (spp, 100.0 * error)
        if isinstance(renderer, Airlight):
            line += "  " + time_to_goal(renderer, picture, truth)
        else:
            line += "  %8.1f s (extrapolated)" % (seconds * (error / GOAL) ** 2)
        print(line, flush=True)


def time_to_goal(airlight, picture, truth):
    for spp in (4, 8, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512):
        seconds = airlight.render(SINGLE, spp, 0, picture, box=False)[1]
        if truth.relative_rmse(picture) <= GOAL:
            return "%8.2f s (whole command, %d spp)" % (seconds, spp)
    return "not reached with 512 spp"


def processor_name():
    try:
        with open("/proc/cpuinfo", encoding="ascii") as file:
            return next(
                line.split(":")[1].strip() for line in file if line.startswith("model name")
            )
    except (OSError, StopIteration):
        return "unknown processor"


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--airlight", metavar="PATH", help="the command; default build/release/airlight"
    )
    parser.add_argument("--repetitions", type=int, default=5, metavar="N")
    parser.add_argument(
        "--spp",
        type=int,
        default=64,
        metavar="N",
        help="samples of a speed measurement; default 64",
    )
    parser.add_argument(
        "--method",
        default="path",
        help="what airlight renders with, compared with Mitsuba's path tracer; default %(default)s",
    )
    parser.add_argument("--threads", type=int, default=os.cpu_count(), metavar="N")
    parser.add_argument("--serve", metavar="VARIANT", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        serve(options.serve, options.threads)
        return
    peers = find_peers(options.threads)
    airlight = Airlight(find_airlight(options.airlight), options.threads, options.method)
    print(
        "roombeam, %d x %d, %s, %d threads%s"
        % (
            WIDTH,
            HEIGHT,
            processor_name(),
            options.threads,
            ", Mitsuba " + peers[0].version if peers else "",
        )
    )
    with tempfile.TemporaryDirectory() as folder:
        print_speed([airlight] + peers, options, folder)
        print_noise([airlight] + peers, options, folder, Truth())
    for peer in peers:
        peer.close()


main()
