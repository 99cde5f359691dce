#!/usr/bin/env python3
"""Scenes made by others: `path` beside Mitsuba 3 and beside reference images, and the fast methods
beside `path`. Needs NumPy, the scenes in ../shared, and, for what is said beside Mitsuba, a Python
that has it.

    python3 bench/truth.py --mitsuba PYTHON --write docs/truth.md

Both render with a box filter until the median over blocks of 4 x 4 pixels of the standard error is
below --error of the block's mean, in 16 independent scramblings. Printed are: that error, of ours
and theirs; the p-value of the worst block, corrected by Sidak for their number (`airlight diff`,
Student's t with 15 degrees of freedom each); how far the pictures' means are apart, in percent and in
standard errors. Of fast methods: bias and relMSE beside ours, the noise of ours taken out, and seconds.

Speed is measured apart, of pictures as users render them, ours with the pattern that is the default:
256 samples per pixel, 5 times in turn, each time with another seed. relMSE is the variance from seed
to seed over the square of the truth (ours, with 1e-4 of the picture's mean squared added), and printed
is relMSE times the median of seconds of rendering, ours over theirs, with the least and the greatest of
the five ratios of seconds in its place.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

import exr
import mitsuba_scene

SEEDS = 16
ROUNDS = 5
TIMED_SAMPLES = 256
MOST_SAMPLES = 1 << 16
METHODS = ("auto", "collimated", "arealight", "ordinates")
LAJOLLA = "hetvol hetvol_colored vol_cbox vol_cbox_teapot volpath_test1 volpath_test2 volpath_test3 "
LAJOLLA += "volpath_test4 volpath_test4_2 volpath_test5 volpath_test5_2 volpath_test6"
SCENES = [f"lajolla_volpath/{name}.xml" for name in LAJOLLA.split()] + [
    "lajolla_cbox/cbox.xml",
    "lajolla_sponza/sponza.xml",
    "mitsuba_cbox/cbox-rgb.xml",
    "bitterli_cornell-box/scene.xml",
    "roombeam/roombeam-mitsuba3.xml",
]
# Media so dense that the offset of Mitsuba's rays from surfaces, about 9e-5 of one more than their
# largest coordinate, is seen: compared once more with a hundredth of it.
DENSE = [f"lajolla_volpath/volpath_test{k}.xml" for k in ("4_2", "5", "5_2", "6")]
REFERENCES = {"bitterli_cornell-box/scene.xml": "bitterli_cornell-box/TungstenRender.exr"}


class Picture:
    """A mean, the variance of it, samples per pixel and seconds of rendering."""

    def __init__(self, mean, variance, samples, seconds):
        self.mean, self.variance = mean, variance
        self.samples, self.seconds = samples, seconds

    def block_error(self):
        """The median standard error of blocks over their means, of those that are not black."""
        mean, variance = blocks(self.mean), blocks(self.variance) / 16.0
        seen = mean > 1e-3 * mean.mean()
        return float(np.median(np.sqrt(variance[seen]) / mean[seen]))


class MitsubaRun:
    """Mitsuba with a scene in it, which renders with one seed after the other."""

    def __init__(self, options, variant, xml, samples, seeds):
        tool = os.path.join(os.path.dirname(os.path.abspath(__file__)), "mitsuba_render.py")
        self.out = os.path.join(options.folder, f"{variant}.npy")
        command = [options.mitsuba, tool, variant, xml, str(samples), str(seeds), self.out]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        self.process = subprocess.Popen(command, text=True, **pipes)
        self._seconds()

    def _seconds(self):
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"truth: {' '.join(self.process.args)}: failed")
        return float(line)

    def render(self):
        """Seconds of one picture."""
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return self._seconds()

    def pictures(self):
        self.process.communicate()
        return np.load(self.out)


def blocks(image):
    high, wide = (n // 4 * 4 for n in image.shape[:2])
    return image[:high, :wide].reshape(high // 4, 4, wide // 4, 4, 3).mean((1, 3))


def limits(depth):
    """Options for so many events, None: any number; 0: none, light that is seen straight."""
    if depth == 0:
        return ["--max-depth", "1", "--terms", "emission,background"]
    return ["--max-depth", "unlimited" if depth is None else str(depth)]


# ---- the two renderers ----


def render(options, scene, size, depth, samples, extra):
    """By airlight; its picture's channels and seconds of rendering."""
    out = os.path.join(options.folder, "ours.exr")
    command = [options.airlight, "render", scene, "-o", out, "--json", "-q", "--filter", "box"]
    command += ["--width", str(size[0]), "--height", str(size[1]), "--spp", str(samples)]
    done = subprocess.run(
        command + limits(depth) + extra, check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    return exr.read(out), json.loads(done.stdout)["seconds"]["render"]


def ours(options):
    def picture(scene, size, depth, samples):
        extra = ["--method", "path", f"--variance={SEEDS}"]
        channels, seconds = render(options, scene, size, depth, samples, extra)
        return Picture(exr.colour(channels), exr.colour(channels, "variance"), samples, seconds)

    return picture


def mitsuba_picture(options, variant, xml, samples):
    """Of a scene as it is."""
    run = MitsubaRun(options, variant, xml, samples // SEEDS, SEEDS)
    seconds = sum(run.render() for _ in range(SEEDS))
    found = run.pictures()
    return Picture(found.mean(0), found.var(0, ddof=1) / SEEDS, samples, seconds)


def theirs(options, variant):
    def picture(scene, size, depth, samples):
        xml = os.path.join(options.folder, "theirs.xml")
        mitsuba_scene.write(scene, xml, *size, depth)
        return mitsuba_picture(options, variant, xml, samples)

    return picture


def converged(options, picture, scene, size, depth):
    """With as many samples as the error asks for."""
    found = picture(scene, size, depth, 8 * SEEDS)
    while found.block_error() > options.error and found.samples < MOST_SAMPLES:
        more = 1.15 * (found.block_error() / options.error) ** 2
        power = max(1, int(np.ceil(np.log2(more))))
        found = picture(scene, size, depth, min(found.samples << power, MOST_SAMPLES))
    return found


# ---- comparing ----


def z_test(options, a, b):
    """What `airlight diff` says of two pictures with variances."""
    paths = []
    for name, picture in (("a", a), ("b", b)):
        for what, image in (("mean", picture.mean), ("variance", picture.variance)):
            paths.append(os.path.join(options.folder, f"{name}-{what}.exr"))
            exr.write(paths[-1], {c: image[..., i] for i, c in enumerate("RGB")})
    command = [options.airlight, "diff", paths[0], paths[2], "--variance-a", paths[1]]
    command += ["--variance-b", paths[3], "--block", "4", "--dof", str(SEEDS - 1), "--json", "-q"]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def whole_bias(a, b):
    """In percent, and in standard errors."""
    gap = a.mean.mean() - b.mean.mean()
    error = np.sqrt((a.variance + b.variance).sum()) / a.mean.size
    return 100.0 * gap / b.mean.mean(), gap / error


def relative(squares, truth):
    """The mean of squared errors or variances over the squares of the truth."""
    return float((squares / (truth**2 + 1e-4 * truth.mean() ** 2)).mean())


def rel_variance(pictures, truth):
    """From picture to picture."""
    return relative(pictures.var(0, ddof=1), truth)


def speeds(options, scene, size, depth, truth):
    """Of each variant: relMSE times seconds, ours over theirs, and the least and the greatest of the
    ratios of seconds in its place."""
    xml = os.path.join(options.folder, "timed.xml")
    mitsuba_scene.write(scene, xml, *size, depth)
    runs = [MitsubaRun(options, v, xml, TIMED_SAMPLES, ROUNDS) for v in options.variants]
    pictures, seconds = [], np.zeros((1 + len(runs), ROUNDS))
    for r in range(ROUNDS):
        extra = ["--method", "path", "--seed", str(r + 1)]
        channels, seconds[0, r] = render(options, scene, size, depth, TIMED_SAMPLES, extra)
        pictures.append(exr.colour(channels))
        seconds[1:, r] = [run.render() for run in runs]
    mine = rel_variance(np.stack(pictures), truth)
    found = []
    for row, run in zip(seconds[1:], runs):
        noise = mine / rel_variance(run.pictures(), truth)
        times = seconds[0] / row
        middle = np.median(seconds[0]) / np.median(row)
        found.append(noise * np.array([middle, times.min(), times.max()]))
    return found


def fast_methods(options, scene, size, depth, truth):
    """Rows of methods whose pictures are not those of path."""
    rows = []
    plain, _ = render(options, scene, size, depth, 16, ["--method", "path"])
    for method in METHODS:
        channels, seconds = render(options, scene, size, depth, 16, ["--method", method])
        image = exr.colour(channels)
        if np.array_equal(image, exr.colour(plain)):
            continue
        error = relative((image - truth.mean) ** 2 - truth.variance, truth.mean)
        bias = 100.0 * (image.mean() / truth.mean.mean() - 1.0)
        rows.append((method, bias, error, seconds))
    return rows


def reference_bias(options, scene, truth_path, depth):
    """Percent between the means of ours, with two-sided materials, and of a reference image."""
    copy = os.path.join(options.folder, "reference.exr")
    source = os.path.join(options.shared, truth_path)
    subprocess.run([options.airlight, "convert", source, copy, "-q"], check=True)
    reference = exr.colour(exr.read(copy))
    size = (reference.shape[1] // 4, reference.shape[0] // 4)
    both = os.path.join(options.folder, "both.xml")
    mitsuba_scene.two_sided(scene, both)
    found = ours(options)(both, size, depth, 1024)
    return 100.0 * (found.mean.mean() / reference.mean() - 1.0)


# ---- the page ----


def beside_mitsuba(options, title, scene, size, depth):
    """Ours, the line of the first table, and the speeds in it."""
    mine = converged(options, ours(options), scene, size, depth)
    line = f"| {title} | {size[0]} x {size[1]} | "
    speed = []
    if options.mitsuba:
        other = converged(options, theirs(options, "scalar_rgb"), scene, size, depth)
        test, (bias, sigmas) = z_test(options, mine, other), whole_bias(mine, other)
        speed = speeds(options, scene, size, depth, mine.mean)
        line += f"{100 * mine.block_error():.1f}, {100 * other.block_error():.1f} | "
        line += f"{test['sidak-p']:.2g} | {bias:+.2f} % | {sigmas:+.1f} | "
        line += " | ".join("{:.2f} ({:.2f} to {:.2f})".format(*s) for s in speed) + " |"
    else:
        line += f"{100 * mine.block_error():.1f} | |"
    return mine, line, [middle for middle, _, _ in speed]


def compare(options, name):
    """The lines of one scene, of the first table and of the second, and its speeds."""
    scene = os.path.join(options.shared, name)
    width, height, depth = mitsuba_scene.film_size(scene)
    size = (options.width, max(4, round(options.width * height / width / 4) * 4))
    title = name.rsplit(".", 1)[0]
    mine, line, speed = beside_mitsuba(options, title, scene, size, depth)
    lines = [line]
    if name in DENSE and options.mitsuba:
        thin = os.path.join(options.folder, "thin.xml")
        mitsuba_scene.thinner(scene, thin, 100.0)
        lines.append(beside_mitsuba(options, title + ", a hundredth", thin, size, depth)[1])
    rows = fast_methods(options, scene, size, depth, mine)
    fast = [f"| {title} | {m} | {b:+.2f} % | {e:.2g} | {s:.2f} |" for m, b, e, s in rows]
    if name in REFERENCES:
        bias = reference_bias(options, scene, REFERENCES[name], depth)
        fast.append(f"| {title} | `path` beside its reference image, two-sided | {bias:+.2f} % | | |")
    print(*lines, *fast, sep="\n", flush=True)
    return lines, fast, speed


NOTES = """## What is known to differ

- **Dense media behind a boundary** (volpath_test4_2, 5, 5_2 and 6: mean free paths of a few thousandths of the sphere). Mitsuba's rays leave a surface about 9e-5 times one more than their largest
  coordinate away from it, which is up to a tenth of a mean free path here, so its pictures depend on the unit of length: the mean of volpath_test5_2 is 0.0221, 0.0265, 0.0270 and 0.0271 with all
  lengths times 0.1, 1, 10 and 100 (and coefficients divided by that); ours is 0.02767 in all four. The truth is known for a plane: Chandrasekhar's H function gives what a dense body sends back of an
  even sky. Ours is within 0.05 % of it in three units of length, theirs off by -97, -5 and -0.3 % (`python3 bench/half_space.py --mitsuba PYTHON`; tests/test_path_half_space.c). With a hundredth of the
  density the two agree, as the lines marked so show.
- The speed of volpath_test5_2 is decided by pixels at the rim of its sphere that one sample in thousands lights, and moves from seed to seed: with 12 seeds of 64 samples ours had 0.70 of their variance.
- One value for all wavelengths is grey in scenes of the versions 0.x, as it was there; Mitsuba 3 makes it white of equal energy, which is reddish. What it renders here has such values as RGB.
- Grids in scenes of 0.x have their first and last values on the sides of their box; what Mitsuba 3 renders here has a box that is larger by half a cell. Negative densities are 0 in both.
- Materials of bitterli_cornell-box reflect on one side, and three walls show their backs: both renderers make them black. Its reference image, by a third renderer, has two-sided walls; beside it stands
  the same scene with every material in `twosided`.
- The classroom is left out: its sky is another model in each renderer (docs/mitsuba-values.md).
"""


def median_line(speeds):
    """Over scenes as their files have them."""
    middles = np.median(np.array(speeds), axis=0)
    return "| median, as the files are | | | | | | " + " | ".join(f"{m:.2f}" for m in middles) + " |"


def page(options, lines, fast):
    variants = " | ".join(f"relMSE x s over {v}" for v in options.variants)
    return "\n".join(
        [
            "# The truth, beside others'",
            "",
            "Made by `python3 bench/truth.py --mitsuba PYTHON --write docs/truth.md`, which says what the columns are. "
            "Scenes made by others, read from Mitsuba's XML.",
            "",
            "## `path` beside Mitsuba 3",
            "",
            f"| scene | pixels | error of blocks, %, ours, theirs | Sidak p | means apart | in standard errors | {variants} |",
            "| --- | --- | --- | --- | --- | --- |" + " --- |" * len(options.variants),
            *lines,
            "",
            "## Fast methods beside `path`",
            "",
            "With 16 samples per pixel; methods that give path's picture are left out.",
            "",
            "| scene | method | bias | relMSE | seconds |",
            "| --- | --- | --- | --- | --- |",
            *fast,
            "",
            NOTES,
        ]
    )


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--airlight", default=os.path.join(here, "../build/release/airlight"))
    parser.add_argument("--shared", default=os.path.join(here, "../../shared/scenes"), type=os.path.abspath)
    parser.add_argument("--mitsuba", help="a Python that has Mitsuba 3")
    parser.add_argument("--variants", nargs="+", default=["scalar_rgb", "llvm_ad_rgb"])
    parser.add_argument("--width", type=int, default=64)
    parser.add_argument("--error", type=float, default=0.02, help="of blocks, over their means")
    parser.add_argument("--only", nargs="+", help="of the scenes")
    parser.add_argument("--write", help="the page")
    options = parser.parse_args()
    if not os.path.isdir(options.shared):
        sys.exit(f"truth: {options.shared}: expected the scenes made by others")
    lines, fast, speeds_found = [], [], []
    with tempfile.TemporaryDirectory() as options.folder:
        for name in options.only or SCENES:
            found, rows, speed = compare(options, name)
            lines += found
            fast += rows
            speeds_found.append(speed)
    if options.mitsuba:
        lines.append(median_line(speeds_found))
        print(lines[-1])
    if options.write:
        with open(options.write, "w") as file:
            file.write(page(options, lines, fast))


if __name__ == "__main__":
    main()
