#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Noise of indirect light against paths a sample, and what each bounce brings.

    experiments/indirect.py [--scene scenes/bunny.yaml] [--size 256] [--most 256] [--paths auto,16]

Renders the exitance of a scene from caches that differ only in --indirect-samples or --bounces and
compares them with the largest. Writes docs/results/indirect.csv and prints it; with --paths only
those are compared, and nothing is written. Seconds are processor seconds of all of pass one.
"""
import argparse
import csv
import pathlib
import resource
import subprocess
import tempfile

import numpy as np
import OpenEXR

ROOT = pathlib.Path(__file__).resolve().parent.parent
BIN = ROOT / "build/release/bin"


def exitance(scene, size, folder, name, flags):
    cache, image = (folder / f"{name}.{end}" for end in ("tallow", "exr"))
    paths = [] if flags["samples"] == "auto" else ["--indirect-samples", str(flags["samples"])]
    bounces = ["--set", f"settings.bounces={flags['bounces']}"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([BIN / "tallow-precompute", scene, "-o", cache, "--quiet",
                    *paths, *bounces], check=True)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    subprocess.run([BIN / "tallow-render", scene, "--cache", cache, "-o", image, "--quiet",
                    "--samples", "1", "--tolerance", "0.001", "--aovs", "exitance",
                    "--set", f"cameras.main.resolution=[{size}, {size}]", *bounces,
                    *[f"--set=materials.{m}.single_scattering=off" for m in flags["materials"]]],
                   check=True)
    with OpenEXR.File(str(image), separate_channels=True) as file:
        channels = file.channels()
        M = np.stack([channels[f"exitance.{c}"].pixels for c in "RGB"])
    return M.astype(np.float64), seconds


def error(M, reference):
    seen = reference.max(axis=0) > 0
    difference = M[:, seen] - reference[:, seen]
    return np.sqrt(np.mean(difference**2)) / np.mean(reference[:, seen]), \
        np.mean(difference) / np.mean(reference[:, seen])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", default="scenes/bunny.yaml")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--materials", nargs="*", default=["marble"])
    parser.add_argument("--most", type=int, default=256, help="paths a sample of the reference")
    parser.add_argument("--paths", help="only these, as auto,16")
    arguments = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)

        def run(samples, bounces):
            return exitance(arguments.scene, arguments.size, folder, f"{samples}_{bounces}",
                            {"samples": samples, "bounces": bounces,
                             "materials": arguments.materials})

        reference, _ = run(arguments.most, 2)
        for samples in (arguments.paths or "auto,1,4,16,64").split(","):
            M, seconds = run(samples, 2)
            rms, bias = error(M, reference)
            rows.append(["samples", samples, f"{rms:.3g}", f"{bias:.2g}", f"{seconds:.2f}"])
        if arguments.paths:
            print("\n".join(",".join(map(str, row)) for row in rows))
            return
        converged, _ = run(16, 6)
        for bounces in (0, 1, 2, 3, 4):
            M, seconds = run(16, bounces)
            rms, bias = error(M, converged)
            rows.append(["bounces", bounces, f"{rms:.3g}", f"{bias:.2g}", f"{seconds:.2f}"])
    out = ROOT / "docs/results/indirect.csv"
    with out.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["varied", "value", "rel_rmse", "bias", "processor_seconds"])
        writer.writerows(rows)
    print(out.read_text())


if __name__ == "__main__":
    main()
