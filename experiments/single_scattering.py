#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Single scattering on the standard cases against volumetric truth, and what it costs.

    experiments/python experiments/single_scattering.py [--connections C ...] [--bin DIR] [CASE ...]

Renders the layer `single` of each case as its scene says (depths follow from the tolerance) and
prints relRMSE with the truth's noise taken off, bias, p99 of averages of 2 x 2 pixels, the share of
the layer's error in all that scattered, and the seconds of the phases `single` and `inner`.
"""
import argparse
import os
import pathlib
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "experiments"))

from harness import programs  # noqa: E402
from harness.cases import all_cases, case_named  # noqa: E402
from harness.images import read_image  # noqa: E402
from harness.metrics import body_mask, compare  # noqa: E402

COLUMNS = ("case", "connection", "relRMSE", "bias", "p99", "noise of the truth",
           "relRMSE of the whole", "s", "load")


def errors(image, truth):
    """Of the layer `single`, as compare() gives them, and as a part of all scattered light."""
    mask = body_mask(truth)
    found = compare(image["single"], truth["single"], mask, truth["single_variance"])
    found["p99"] = compare(image["single"], truth["single"], mask, block=2)["p99"]
    found["whole"] = found["relRMSE"] * float(truth["single"][mask].mean() / truth[""][mask].mean())
    return found


def render(case, connection, arguments, folder):
    """The picture of a case, and the seconds of its single scattering."""
    cache, picture = folder / f"{case.name}.tallow", folder / f"{case.name}-{connection}.exr"
    scene = ["--set", "settings.bounces=0", *case.flags(single_scattering=connection)]
    if not cache.exists():
        programs.run("tallow-precompute", case.scene, "-o", cache, *scene, bin=arguments.bin)
    flags = ["--samples", str(arguments.samples), "--tolerance", str(arguments.tolerance)]
    run = programs.run("tallow-render", case.scene, "--cache", cache, "-o", picture, "--aovs",
                       "single", *flags, *scene, bin=arguments.bin, timeout=arguments.timeout)
    seconds = run.stats["seconds"]
    return read_image(picture), seconds.get("single", 0.0) + seconds.get("inner", 0.0)


def row(case, connection, arguments, folder):
    image, seconds = render(case, connection, arguments, folder)
    e = errors(image, read_image(case.reference))
    percents = (f"{100 * e['relRMSE']:.1f} %", f"{100 * e['bias']:+.1f} %", f"{e['p99']:.2f}",
                f"{100 * e['noise']:.0f} %", f"{100 * e['whole']:.2f} %")
    return (case.name, connection, *percents, f"{seconds:.2f}", f"{os.getloadavg()[0]:.1f}")


def line(cells):
    return "| " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("cases", nargs="*")
    parser.add_argument("--connections", nargs="+", default=["auto", "straight"])
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--tolerance", type=float, default=0.01)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--timeout", type=float, default=None)
    parser.add_argument("--folder", type=pathlib.Path, default=None, help="keeps the pictures")
    arguments = parser.parse_args()
    cases = [case_named(name) for name in arguments.cases] or all_cases()
    print(line(COLUMNS) + "\n" + line(["---"] * len(COLUMNS)), flush=True)
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for case in cases:
            for connection in arguments.connections:
                print(line(row(case, connection, arguments, folder)), flush=True)


if __name__ == "__main__":
    main()
