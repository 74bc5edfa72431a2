#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tallow-reference against itself: its combined estimator and walks from the camera alone.

experiments/reference_check.py BIN FIGURE MEDIUM [--seeds 6]
prints, for each layer, both means over the body and their difference in standard errors. The error of
the combined estimator comes from the scatter of runs with different seeds, because its pixels are not
independent; that of the walks from the camera from their variance, because theirs are.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from references import HERE, mean_colour, read_channels, read_media

LAYERS = ["single", "multi", "ext", "mirror"]


def run(program: pathlib.Path, figure: str, medium: str, estimator: str,
        seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean of each layer and channel over the body, and its variance if pixels are independent."""
    with tempfile.TemporaryDirectory() as folder:
        image = pathlib.Path(folder) / "image.exr"
        subprocess.run([str(program), str(HERE / "cases" / f"{figure}.yaml"), "-o", str(image),
                        "--set", f"materials.body={read_media()[medium]}", "--paths", "3e6",
                        "--estimator", estimator, "--seed", str(seed), "--quiet"], check=True)
        channels, _ = read_channels(image)
    body = channels["A"] > 0.5
    mean = np.array([mean_colour(channels, layer, body) for layer in LAYERS])
    variance = np.array([mean_colour(channels, layer + "_variance", body) for layer in LAYERS])
    return mean, variance / body.sum()


def estimate(program: pathlib.Path, figure: str, medium: str, estimator: str,
             seeds: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean over the seeds and its standard error."""
    runs = [run(program, figure, medium, estimator, seed) for seed in range(1, seeds + 1)]
    means = np.array([mean for mean, _ in runs])
    if estimator == "camera":
        variance = np.mean([variance for _, variance in runs], axis=0)
    else:
        variance = means.var(axis=0, ddof=1)
    return means.mean(axis=0), np.sqrt(variance / seeds)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path, help="folder of tallow-reference")
    parser.add_argument("figure")
    parser.add_argument("medium")
    parser.add_argument("--seeds", type=int, default=6)
    arguments = parser.parse_args()
    program = arguments.bin.resolve() / "tallow-reference"
    means, errors = {}, {}
    for estimator in ("combined", "camera"):
        means[estimator], errors[estimator] = estimate(program, arguments.figure, arguments.medium,
                                                       estimator, arguments.seeds)
    print("| layer | combined, R G B | camera, R G B | difference in standard errors |")
    print("|---|---|---|---|")
    for i, layer in enumerate(LAYERS):
        error = np.hypot(errors["combined"][i], errors["camera"][i])
        z = np.divide(means["combined"][i] - means["camera"][i], error, where=error > 0,
                      out=np.zeros(3))
        both = [" ".join(f"{m:.5f}" for m in means[e][i]) for e in ("combined", "camera")]
        print(f"| {layer} | {both[0]} | {both[1]} | {' '.join(f'{v:+.1f}' for v in z)} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
