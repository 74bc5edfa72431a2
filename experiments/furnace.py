#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The white furnace: light 1 from everywhere and no absorption, so that every pixel should be 1.

    experiments/python experiments/furnace.py [--model MODEL ...] [--eta ETA] [FIGURE ...]

Renders figures of experiments/cases in a medium of mean free paths 1.4, 0.8 and 0.4 mm and prints
the mean of the pixels that see the body alone, and the root mean square of (pixel - 1), a channel.
What is missing or too much is light that the model loses or counts twice.
"""
import argparse
import pathlib
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "experiments"))

from harness import programs  # noqa: E402
from harness.cases import CASES  # noqa: E402
from harness.images import read_image  # noqa: E402

ONLY_BODY = 0.999  # of a pixel


def pixels(figure, model, eta, folder):
    """The picture's pixels that see nothing but the body, (n, 3)."""
    body = ("materials.body={type: subsurface, sigma_s_prime: [0.7, 1.22, 2.6], "
            f"sigma_a: [0, 0, 0], eta: {eta}, model: {model}}}")
    flags = ["--set", body, "--set", "lights=[{type: environment, radiance: [1, 1, 1]}]"]
    cache, image = folder / "furnace.tallow", folder / "furnace.exr"
    scene = CASES / f"{figure}.yaml"
    programs.run("tallow-precompute", scene, "-o", cache, *flags)
    programs.run("tallow-render", scene, "--cache", cache, "-o", image, *flags)
    picture = read_image(image)
    return picture[""][picture.coverage >= ONLY_BODY].astype(numpy.float64)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("figures", nargs="*", default=["sphere", "leaf", "bunny", "armadillo"])
    parser.add_argument("--model", nargs="+", default=["body-aware", "transport"])
    parser.add_argument("--eta", type=float, default=1.3)
    arguments = parser.parse_args()
    print("| figure | model | mean R, G, B | root mean square of (pixel - 1) |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for figure in arguments.figures:
            for model in arguments.model:
                L = pixels(figure, model, arguments.eta, pathlib.Path(folder))
                mean, rms = L.mean(axis=0), numpy.sqrt(((L - 1) ** 2).mean(axis=0))
                print(f"| {figure} | {model} | {', '.join(f'{x:.3f}' for x in mean)} | "
                      f"{', '.join(f'{x:.3f}' for x in rms)} |", flush=True)


if __name__ == "__main__":
    main()
