#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How much of the light that leaves a body and meets it again does tallow have?

    experiments/python experiments/reentry.py [CASE ...]

For standard cases (bunny-skin1) what indirect light adds to a picture, summed over it, against the
layer `ext` of its reference: light that did not come straight from the lamp. By channel, with the
layer's share of all light. Exact single scattering, default settings.
"""
import pathlib
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "experiments"))

from harness import cases, programs  # noqa: E402
from harness.images import read_image  # noqa: E402

STANDARD = [f"{figure}-{medium}" for figure in ("bunny", "armadillo", "leaf")
            for medium in ("marble", "skimmilk", "skin1", "dim")]


def scattered(case, flags, cache, image, *more):
    programs.run("tallow-render", case.scene, "--cache", cache, "-o", image, "--aovs", "all",
                 "--samples", "4", *flags, *more)
    layers = read_image(image)
    return layers["multiple"] + layers["single"]


def main():
    names = sys.argv[1:] or STANDARD
    print("| case | of the truth, R, G, B | standard error | share of all light |\n|---|---|---|---|")
    for name in names:
        case = cases.case_named(name)
        flags = case.flags(single_scattering="exact")
        truth = read_image(case.reference)
        with tempfile.TemporaryDirectory() as folder:
            cache, image = pathlib.Path(folder) / "cache", pathlib.Path(folder) / "image.exr"
            programs.run("tallow-precompute", case.scene, "-o", cache, *flags)
            on = scattered(case, flags, cache, image)
            off = scattered(case, flags, cache, image, "--set", "settings.bounces=0")
        body = truth[""].max(axis=-1) > 0
        ext = truth["ext"][body].sum(axis=0)
        ratio = (on - off)[body].sum(axis=0) / ext
        error = numpy.sqrt(truth["ext_variance"][body].sum(axis=0)) / ext
        share = ext / truth[""][body].sum(axis=0)
        print(f"| {name} | {', '.join(f'{x:.2f}' for x in ratio)} | {error.max():.3f} | "
              f"{', '.join(f'{100 * x:.0f} %' for x in share)} |", flush=True)


if __name__ == "__main__":
    main()
