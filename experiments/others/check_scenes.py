#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Are the scenes equal in tallow, Mitsuba and Cycles? Silhouettes and direct irradiance.

    experiments/others/check_scenes.py [CASE ...] [--seconds 10]

Renders each case with an opaque Lambertian body of reflectance 0.5, without indirect light, and
compares with tallow (radiance over the pixels that the body fills):

    area      the body's, in pixels, relative difference
    outline   sum |A - A'| / sum A over the image: an image shifted by a pixel has several per cent
    mean      of the radiance, relative difference, with the standard error of the other's noise
    picture   relRMSE of the radiance, the other's noise subtracted; what noise could leave of it

Exits with 1 if one of them exceeds 1 % (and, in pictures, what noise could leave). Renderers that
are not installed are left out and named.
"""
import argparse
import dataclasses
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

if not __package__:  # run as a program: the folder above holds the package
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
    __package__ = "others"
from . import cycles_render, mitsuba_render, passes, scene

CASES = ("sphere", "bunny", "armadillo", "leaf")
LIMIT = 0.01
FINER = 16  # subpixels of tallow along an edge of a pixel
GREY = scene.Diffuse(np.full(3, 0.5))


def load(name):
    """The diffuse case, and what makes it of the file for tallow.

    The lamp stands behind the leaf, where an opaque leaf is dark: it is mirrored to the front.
    """
    case = scene.load_case(name, GREY)
    changes = ["materials.body={type: diffuse, reflectance: [0.5, 0.5, 0.5]}", "settings.bounces=0"]
    if case.file.stem == "leaf":
        lamp, = case.lights
        position = lamp.center * [1, 1, -1]
        changes.append(f"lights.0.position={position.tolist()}")
        mirrored = scene.make_quad(position, np.array([0, 17, 0]), np.array([0, 1, 0]),
                                   [36, 36], lamp.radiance)
        case = dataclasses.replace(case, lights=(mirrored,))
    return case, changes


def tallow(case, changes, programs):
    """Coverage and radiance of the changed case by tallow-render, through FINER^2 subpixels."""
    width, height = FINER * case.camera.width, FINER * case.camera.height
    with tempfile.TemporaryDirectory() as folder:
        image = pathlib.Path(folder) / "tallow.exr"
        command = [programs / "tallow-render", case.file, "-o", image, "--quiet", "--samples", "1",
                   "--set", f"cameras.main.resolution=[{width}, {height}]",
                   *[f"--set={change}" for change in changes]]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise scene.InputError(done.stderr.strip())
        channels = passes.read_exr(image)
    return boxed(channels["A"]), boxed(passes.layer(channels))


def boxed(image):
    """Means over squares of FINER^2 pixels."""
    height, width = image.shape[0] // FINER, image.shape[1] // FINER
    return image.reshape(height, FINER, width, FINER, *image.shape[2:]).mean(axis=(1, 3))


def mitsuba(case, seconds):
    """Coverage and an estimate of the radiance. The silhouette hides a white surrounding."""
    black = dataclasses.replace(case, material=scene.Diffuse(np.zeros(3)),
                                lights=(scene.Environment(np.ones(3)),))
    coverage = 1 - mitsuba_render.Mitsuba(black, max_depth=1).render(1, 1024)[..., 0]
    renderer = mitsuba_render.Mitsuba(case, max_depth=2)
    return coverage, passes.accumulate(renderer, case.camera, seconds=seconds)


def cycles(case, seconds):
    """Coverage and an estimate of the radiance."""
    renderer = cycles_render.Cycles(case, bounces=0)
    coverage = renderer.channels(1, 1024)["A"]
    return coverage, passes.accumulate(renderer, case.camera, seconds=seconds)


def compare(ours, theirs):
    """{area, outline, mean, noise, picture, blur} of (coverage, image) and (coverage, estimate)."""
    (A, image), (other_A, estimate) = ours, theirs
    inside = np.minimum(A, other_A) > 0.999
    difference = estimate.mean[inside] - image[inside]
    squares = difference**2 - estimate.variance[inside]
    two_errors = 2 * squares.std() / np.sqrt(squares.size)
    return {"area": other_A.sum() / A.sum() - 1,
            "outline": np.abs(other_A - A).sum() / A.sum(),
            "mean": estimate.mean[inside].sum() / image[inside].sum() - 1,
            "noise": np.sqrt(estimate.variance[inside].sum()) / image[inside].sum(),
            "picture": np.sqrt(max(0, squares.mean())) / image[inside].mean(),
            "blur": np.sqrt(two_errors) / image[inside].mean()}


def available():
    """The renderers that can be used here, by name."""
    found = {}
    try:
        mitsuba_render.load_mitsuba(mitsuba_render.default_variant())
        found["mitsuba"] = mitsuba
    except scene.InputError as error:
        print(f"left out: mitsuba ({error})", file=sys.stderr)
    if cycles_render.is_available():
        found["cycles"] = cycles
    else:
        print("left out: cycles (bpy is not installed)", file=sys.stderr)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", default=CASES)
    parser.add_argument("--seconds", type=passes.positive(float), default=10, help="a render")
    parser.add_argument("--programs", type=pathlib.Path, default=scene.ROOT / "build/release/bin")
    arguments = parser.parse_args()
    renderers = available()
    print("case       renderer   area %  outline %   mean % +- noise   picture % +- noise")
    equal = True
    for name in arguments.cases:
        case, changes = load(name)
        ours = tallow(case, changes, arguments.programs)
        for renderer, render in renderers.items():
            row = compare(ours, render(case, arguments.seconds))
            equal &= all(abs(row[key]) < LIMIT for key in ("area", "outline", "mean"))
            equal &= row["picture"] < np.hypot(LIMIT, row["blur"])
            percent = {key: 100 * value for key, value in row.items()}
            print("{:10} {:9} {area:7.3f} {outline:10.3f} {mean:8.3f} +- {noise:.3f} "
                  "{picture:7.3f} +- {blur:.3f}".format(case.file.stem, renderer, **percent),
                  flush=True)
    return 0 if equal and renderers else 1


if __name__ == "__main__":
    sys.exit(passes.run(main))
