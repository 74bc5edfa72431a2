#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error against seconds of another renderer, measured against a reference picture.

    experiments/others/error_curve.py sphere dim REF.exr --renderer mitsuba --seconds 120

One render in passes; its mean is compared after 2, 4, 8, .. passes and at the end. The error is

    relRMSE = sqrt(mean((I - R)^2) - mean(variance of R)) / mean(R)

over all channels and the pixels that the body covers (A > 0.5) and where no unscattered light
shows: I holds it and R, the reference's R, G, B, does not, so pixels (and their neighbours) with a
`mirror` above 1 % of the mean of R are left out, for all renderers alike.

`noise` is the part that the renderer's own spread explains, `bias` the relative difference of
means, `floor` what remains without noise, and not less than the bias. For Mitsuba, whose model is
the reference's, it is taken for 0 when times are extrapolated. With floor f and noise s after t
seconds, an error e is reached after t s^2 / (e^2 - f^2), never if e <= f.
"""
import argparse
import csv
import pathlib
import sys

import numpy as np

if not __package__:  # run as a program: the folder above holds the package
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
    __package__ = "others"
from . import check_reference, cycles_render, mitsuba_render, passes, scene

TARGETS = (0.10, 0.05, 0.02, 0.01)
RENDERERS = {"mitsuba": lambda case: mitsuba_render.Mitsuba(case),
             "cycles-random-walk": lambda case: cycles_render.Cycles(case, "random_walk"),
             "cycles-burley": lambda case: cycles_render.Cycles(case, "burley")}
MIRROR = 0.01  # of the mean of R


class Truth:
    """A reference picture and the pixels that count."""

    def __init__(self, path):
        channels = passes.read_exr(path)
        self.R, mirror, variance = (passes.layer(channels, name, path)
                                    for name in ("", "mirror", "variance"))
        if "A" not in channels:
            raise scene.InputError(f"{path}: expected channel 'A'")
        body = channels["A"] > 0.5
        mirrored = np.any(mirror > MIRROR * self.R[body].mean(), axis=2)
        self.mask = body & ~check_reference.grown(mirrored)
        if not self.mask.any():
            raise scene.InputError(f"{path}: shows unscattered light in every pixel")
        self.mean = self.R[self.mask].mean()
        self.noise2 = variance[self.mask].mean()

    def square_error(self, image):
        """Mean squared error without the reference's own noise; may fall below 0 by chance."""
        return np.mean((image - self.R)[self.mask] ** 2) - self.noise2

    def row(self, estimate):
        """What a curve's row holds."""
        square, noise2 = (value / self.mean**2 for value in (
            self.square_error(estimate.mean), estimate.variance[self.mask].mean()))
        bias = (estimate.mean - self.R)[self.mask].mean() / self.mean
        return {"seconds": estimate.seconds, "startup_seconds": estimate.startup_seconds,
                "spp": estimate.spp, "relRMSE": float(np.sqrt(max(square, 0))),
                "noise": float(np.sqrt(noise2)),
                "floor": float(max(np.sqrt(max(square - noise2, 0)), abs(bias))),
                "bias": float(bias)}


def curve(case, truth, renderer, seconds):
    """Rows of a render of `seconds`, from nested numbers of passes."""
    rows = []

    def on_pass(estimate):
        if estimate.passes > 1 and estimate.passes & (estimate.passes - 1) == 0:
            rows.append(truth.row(estimate))

    estimate = passes.accumulate(RENDERERS[renderer](case), case.camera, seconds=seconds,
                                 on_pass=on_pass)
    if rows[-1]["spp"] != estimate.spp:
        rows.append(truth.row(estimate))
    return rows


def seconds_to(rows, target, floor=None):
    """Extrapolated seconds of rendering to a relRMSE, or infinity; `floor` or the last row's."""
    last = rows[-1]
    floor = last["floor"] if floor is None else floor
    if target <= floor:
        return float("inf")
    return last["seconds"] * last["noise"] ** 2 / (target**2 - floor**2)


def write_csv(file, rows):
    writer = csv.DictWriter(file, rows[0], lineterminator="\n")
    writer.writeheader()
    writer.writerows({key: f"{value:.6g}" for key, value in row.items()} for row in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", metavar="CASE", help="a standard case by name, or its file")
    parser.add_argument("medium", metavar="MEDIUM", help="one of media.yaml, or {type: ..}")
    parser.add_argument("reference", metavar="REF.exr", help="by tallow-reference")
    parser.add_argument("--renderer", choices=RENDERERS, required=True)
    parser.add_argument("--seconds", type=passes.positive(float), default=120)
    parser.add_argument("-o", "--output", metavar="CURVE.csv", help="[default: stdout]")
    arguments = parser.parse_args()
    if arguments.renderer.startswith("cycles") and not cycles_render.is_available():
        print("error_curve: needs Blender as a module: pip install bpy (Python 3.11)",
              file=sys.stderr)
        return 2
    case = scene.load_case(arguments.case, scene.find_material(arguments.medium))
    truth = Truth(arguments.reference)
    rows = curve(case, truth, arguments.renderer, arguments.seconds)
    if arguments.output:
        with open(arguments.output, "w", newline="") as file:
            write_csv(file, rows)
    else:
        write_csv(sys.stdout, rows)
    floor = 0.0 if arguments.renderer == "mitsuba" else None
    for target in TARGETS:
        print(f"{100 * target:g} % after {seconds_to(rows, target, floor):.4g} s", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(passes.run(main))
