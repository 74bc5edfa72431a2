#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How much light enters a body, and enters again: pass one's samples against walks that are counted.

    experiments/python experiments/light_balance.py [--paths N] [CASE ...]

For standard cases (bunny-skin1), by channel, as parts of what enters straight from the lamp: what
enters after one meeting with the body more (it was mirrored, passed through, or left it scattered),
and what after two or more. `direct` is what enters straight from the lamp, ours over the truth. Needs
no pictures: what samples receive, times their areas, is the light that enters.
"""
import argparse
import csv
import io
import pathlib
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "experiments"))

from harness import cases, programs  # noqa: E402

STANDARD = [f"{figure}-{medium}" for figure in ("bunny", "armadillo", "leaf")
            for medium in ("marble", "skimmilk", "skin1")]
SAMPLE = numpy.dtype([(name, "<f4") for name in (
    "x", "y", "z", "nx", "ny", "nz", "area", "r", "g", "b")] + [("colour", "u1", 3), ("body", "<i4")])


def entering(case, bounces, folder):
    """What enters through all samples with so many bounces, W by channel."""
    points = folder / "samples.ply"
    programs.run("tallow-precompute", case.scene, "-o", folder / "cache", "--export-ply", points,
                 "--bounces", str(bounces), *case.flags())
    bytes_ = points.read_bytes()
    samples = numpy.frombuffer(bytes_[bytes_.index(b"end_header\n") + 11:], SAMPLE)
    areas = samples["area"].astype(float)
    return numpy.array([(areas * samples[c]).sum() for c in "rgb"])


def counted(case, paths):
    """What walks find, W by channel: straight from the lamp, after one meeting, after more."""
    run = programs.run("tallow-reference-balance", case.scene, "--paths", str(paths), *case.flags())
    rows = {row["event"]: numpy.array([float(row[c]) for c in "rgb"])
            for row in csv.DictReader(io.StringIO(run.stdout))}
    return (rows["entered_first"], rows["entered_bare"] + rows["entered_second"],
            rows["entered_later"])


def percent(values):
    return ", ".join(f"{100 * value:.1f}" for value in values) + " %"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("cases", nargs="*")
    parser.add_argument("--paths", type=int, default=1_000_000)
    arguments = parser.parse_args()
    print("| case | direct | once more | truth | later | truth |\n|---|---|---|---|---|---|")
    for name in arguments.cases or STANDARD:
        case = cases.case_named(name)
        first, second, later = counted(case, arguments.paths)
        with tempfile.TemporaryDirectory() as folder:
            ours = [entering(case, bounces, pathlib.Path(folder)) for bounces in (0, 1, 2)]
        print(f"| {name} | {percent(ours[0] / first)} | {percent((ours[1] - ours[0]) / ours[0])} | "
              f"{percent(second / first)} | {percent((ours[2] - ours[1]) / ours[0])} | "
              f"{percent(later / first)} |", flush=True)


if __name__ == "__main__":
    main()
