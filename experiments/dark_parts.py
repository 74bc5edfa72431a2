#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How right a picture is where it is dark, on the standard cases against volumetric truth.

    experiments/python experiments/dark_parts.py [--bin DIR] [--set KEY=VALUE] [CASE ...]

The reference's noise hides what single dark pixels are worth. So all pixels and channels that are
of a like brightness in *our* picture, which knows nothing of that noise, are added up: prints our
light over the truth's for each range of brightness (of the channel's mean), with the standard error
of the truth, and how many pixels times channels there are.
"""
import argparse
import pathlib
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "experiments"))

from harness import programs  # noqa: E402
from harness.cases import case_named  # noqa: E402
from harness.images import read_image  # noqa: E402
from harness.metrics import body_mask  # noqa: E402

CASES = ("bunny-marble", "bunny-skimmilk", "sphere-marble", "sphere-skimmilk", "armadillo-marble",
         "armadillo-skimmilk")
EDGES = (0, 0.01, 0.02, 0.05, 0.1, 0.3, 1, np.inf)
FEWEST = 50  # pixels times channels, below which a range says nothing


def render(case, arguments, folder):
    cache, picture = (folder / f"{case.name}.{end}" for end in ("tallow", "exr"))
    flags = case.flags(model=arguments.model, single_scattering="exact")
    for change in arguments.set:
        flags += ["--set", change]
    programs.run("tallow-precompute", case.scene, "-o", cache, *flags, bin=arguments.bin)
    programs.run("tallow-render", case.scene, "--cache", cache, "-o", picture, "--aovs", "all",
                 "--samples", "64", *flags, bin=arguments.bin)
    return read_image(picture)


def cell(chosen, ours, truth, variance):
    if chosen.sum() < FEWEST:
        return "-"
    sum_of_truth = truth[chosen].sum()
    error = np.sqrt(variance[chosen].sum()) / sum_of_truth
    return f"{ours[chosen].sum() / sum_of_truth:.2f} ± {error:.2f} ({chosen.sum():,})"


def row(case, arguments, folder):
    truth = read_image(case.reference)
    mask = body_mask(truth)
    ours, light, variance = (np.asarray(image[mask], np.float64) for image in
                             (render(case, arguments, folder)["scattered"], truth[""],
                              truth["variance"]))
    brightness = ours / light.mean(axis=0)
    return (case.name, *(cell((brightness > low) & (brightness <= high), ours, light, variance)
                         for low, high in zip(EDGES, EDGES[1:])))


def line(cells):
    return "| " + " | ".join(cells) + " |"


def title(low, high):
    if high == np.inf:
        return f"> {100 * low:g} %"
    return f"{100 * low:g} to {100 * high:g} %"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("cases", nargs="*")
    parser.add_argument("--bin", default=ROOT / "build/release/bin", type=pathlib.Path)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--model", default="body-aware")
    arguments = parser.parse_args()
    titles = ("case", *(title(low, high) for low, high in zip(EDGES, EDGES[1:])))
    print(line(titles))
    print(line(["---"] * len(titles)))
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.cases or CASES:
            print(line(row(case_named(name), arguments, pathlib.Path(folder))), flush=True)


if __name__ == "__main__":
    main()
