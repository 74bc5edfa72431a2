#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error of the hierarchical sum against the plain sum, for a range of tolerances.

Prints a Markdown table: relRMSE over all pixels that see the body, seconds of the exitance phase and
kernel evaluations a shading point (all channels). Needs the release build, the scanned meshes
(./run fetch) and `pip install numpy OpenEXR`.

    experiments/hierarchy_error.py [SCENE ...]
"""
import json
import pathlib
import subprocess
import sys

import numpy
import OpenEXR

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "hierarchy_error"
TOLERANCES = [0.1, 0.03, 0.01, 0.003, 0.001, 0.0003]
RESOLUTION = "[96, 96]"


def run(program, *arguments):
    command = [ROOT / "build/release/bin" / program, *arguments, "--quiet"]
    subprocess.run(list(map(str, command)), check=True)


def exitance(file):
    with OpenEXR.File(str(file), separate_channels=True) as exr:
        channels = exr.channels()
        return numpy.stack([channels["exitance." + c].pixels for c in "RGB"], -1).astype(float)


def render(scene, cache, tolerance):
    image, stats = OUT / "image.exr", OUT / "stats.json"
    run("tallow-render", scene, "--cache", cache, "-o", image, "--stats", stats, "--samples", 1,
        "--aovs", "exitance", "--tolerance", tolerance,
        "--set", f"cameras.main.resolution={RESOLUTION}",
        "--set", "materials.marble.single_scattering=off")
    return exitance(image), json.loads(stats.read_text())


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    scenes = sys.argv[1:] or ["bunny", "armadillo", "demo"]
    print("| scene | samples | tolerance | relRMSE | exitance, s | evaluations a point |")
    print("|---|---|---|---|---|---|")
    for name in scenes:
        scene, cache = ROOT / "scenes" / f"{name}.yaml", OUT / f"{name}.tallow"
        run("tallow-precompute", scene, "-o", cache)
        plain, _ = render(scene, cache, 0)
        body = plain[..., 1] > 0
        for tolerance in TOLERANCES:
            fast, stats = render(scene, cache, tolerance)
            error = numpy.sqrt(numpy.mean((fast[body] - plain[body]) ** 2)) / numpy.mean(plain[body])
            counts = stats["counts"]
            print(f"| {name} | {counts['lit_samples']} | {tolerance} | {error:.5f} "
                  f"| {stats['seconds']['exitance']:.3f} "
                  f"| {counts['evaluations'] / counts['exitance_points']:.0f} |", flush=True)


if __name__ == "__main__":
    main()
