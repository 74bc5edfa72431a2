#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Light that leaves a body and meets it again, on the standard cases against volumetric truth.

    experiments/python experiments/external_light.py [--bin DIR] [--set KEY=VALUE] [CASE ...]

The reference keeps it in a layer of its own, `ext`. Here it is what a picture with indirect light
scatters, less its single scattering and less the multiple scattering of a picture without:

    ext = scattered - single - multiple(bounces 0)

Prints the layer's share of all that scatters, its bias per channel, its relRMSE with the truth's
noise taken off, and the seconds of the phase `indirect`.
"""
import argparse
import os
import pathlib
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "experiments"))

from harness import programs  # noqa: E402
from harness.cases import case_named  # noqa: E402
from harness.images import read_image  # noqa: E402
from harness.metrics import body_mask, compare  # noqa: E402

CASES = ("armadillo-marble", "armadillo-skimmilk", "armadillo-skin1", "bunny-marble",
         "bunny-skimmilk", "bunny-skin1")
COLUMNS = ("case", "share", "bias R", "bias G", "bias B", "relRMSE", "noise of the truth",
           "s", "load")


def render(case, bounces, arguments, folder):
    """The picture of a case with so many bounces ("auto": as it comes), and pass one's seconds."""
    cache, picture = (folder / f"{case.name}-{bounces}.{end}" for end in ("tallow", "exr"))
    flags = ["--set", f"settings.bounces={bounces}", *case.flags(model=arguments.model)]
    for change in arguments.set:
        flags += ["--set", change]
    first = programs.run("tallow-precompute", case.scene, "-o", cache, *flags, bin=arguments.bin)
    programs.run("tallow-render", case.scene, "--cache", cache, "-o", picture, "--aovs", "all",
                 *flags, bin=arguments.bin)
    return read_image(picture), first.stats["seconds"].get("indirect", 0.0)


def row(case, arguments, folder):
    dark, _ = render(case, 0, arguments, folder)
    lit, seconds = render(case, "auto", arguments, folder)
    truth = read_image(case.reference)
    mask = body_mask(truth)
    found = lit["scattered"] - lit["single"] - dark["multiple"]
    e = compare(found, truth["ext"], mask, truth["ext_variance"])
    mean = truth["ext"][mask].mean(axis=0, dtype=np.float64)
    bias = (found - truth["ext"])[mask].mean(axis=0, dtype=np.float64) / mean
    share = mean.sum() / truth[""][mask].mean(axis=0, dtype=np.float64).sum()
    return (case.name, f"{100 * share:.0f} %", *(f"{100 * b:+.1f} %" for b in bias),
            f"{100 * e['relRMSE']:.0f} %", f"{100 * e['noise']:.0f} %", f"{seconds:.1f}",
            f"{os.getloadavg()[0]:.1f}")


def line(cells):
    return "| " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("cases", nargs="*")
    parser.add_argument("--model", default="body-aware")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    arguments = parser.parse_args()
    print(line(COLUMNS) + "\n" + line(["---"] * len(COLUMNS)), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.cases or CASES:
            print(line(row(case_named(name), arguments, pathlib.Path(folder))), flush=True)


if __name__ == "__main__":
    main()
