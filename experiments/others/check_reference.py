#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares pictures of tallow-reference with Mitsuba: channel means and a grid of regions.

    experiments/others/check_reference.py REF.exr .. --case sphere --medium dim --seconds 60

All light is compared that comes from the body: the reference's R, G, B and its layer `mirror`.
Pixels where the lamp's mirror image outshines the rest are kept apart ("mirror"), or its noise
would hide what is scattered; of three pictures or more, the first only tells where. Only pixels
that the body fills count.

A walk of the reference reaches many pixels, whose errors are then alike: the standard error of a
sum of pixels cannot come from their variances. Give several pictures of different --seed, and it
comes from their spread; of one picture it is taken from the variances and printed as too small.
Mitsuba's pixels are independent.

Exits with 1 if a mean differs by more than 2 standard errors (which equal pictures do in one run of
four, with two kinds of pixels in three channels) or chi-square over the regions has a probability
below 1 %. Sums that Mitsuba knows to no better than 5 % are printed and decide nothing: before it
has met its rare bright paths, its error looks too small and its mean is too dark.
"""
import argparse
import math
import pathlib
import sys

import numpy as np

if not __package__:  # run as a program: the folder above holds the package
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
    __package__ = "others"
from . import mitsuba_render, passes, scene

GRID = 4
FEW_PICTURES = 12  # chosen: their spread is known to 20 %
FEWEST = 0.05  # relative standard error; above it Mitsuba has too few hits to know its error


class Reference:
    """Pictures of the same scene by tallow-reference, with different seeds."""

    def __init__(self, paths):
        files = [(path, passes.read_exr(path)) for path in paths]
        self.coverage = files[0][1]["A"]
        layers = {name: np.stack([passes.layer(channels, name, path) for path, channels in files])
                  for name in ("", "mirror", "variance", "mirror_variance")}
        self.mirrored = np.any(layers["mirror"][0] > np.maximum(layers[""][0], 0), axis=2)
        # A picture whose noise chose pixels would be biased on them.
        used = slice(1 if len(files) > 2 else 0, None)
        self.pictures = (layers[""] + layers["mirror"])[used]
        self.variance = (layers["variance"] + layers["mirror_variance"]).mean(axis=0)

    def sums(self, mask):
        """Sum over the pixels of a mask, mean of all pictures, and its variance, a channel each."""
        count = len(self.pictures)
        sums = self.pictures[:, mask].sum(axis=1)
        if count == 1:
            return sums[0], self.variance[mask].sum(axis=0)
        return sums.mean(axis=0), sums.var(axis=0, ddof=1) / count

    def pooled_sums(self, masks):
        """As sums(), of masks of like size: [(sum, variance), ..].

        The spread of a few pictures is a poor variance for each mask. What pixels have in common
        makes it larger than the pixels' variances by a factor that all masks together tell.
        """
        count = len(self.pictures)
        rows = [(*self.sums(mask), self.variance[mask].sum(axis=0) / count) for mask in masks]
        spread, independent = (sum(row[i] for row in rows) for i in (1, 2))
        factor = spread / np.maximum(independent, 1e-300)
        return [(total, factor * variance) for total, _, variance in rows]


def grown(mask):
    """The pixels of a mask and their eight neighbours."""
    padded = np.pad(mask, 1)
    height, width = mask.shape
    return np.logical_or.reduce([padded[y:y + height, x:x + width]
                                 for y in range(3) for x in range(3)])


def regions(mask):
    """Masks of the GRID^2 parts of the box around a mask."""
    if not mask.any():
        return
    ys, xs = np.nonzero(mask)
    rows = np.clip((ys - ys.min()) * GRID // (np.ptp(ys) + 1), 0, GRID - 1)
    columns = np.clip((xs - xs.min()) * GRID // (np.ptp(xs) + 1), 0, GRID - 1)
    for index in range(GRID * GRID):
        inside = rows * GRID + columns == index
        part = np.zeros_like(mask)
        part[ys[inside], xs[inside]] = True
        yield part


def differences(ours, estimate, mask):
    """Relative difference of sums (reference over Mitsuba), its standard error, Mitsuba's own."""
    total, variance = ours
    theirs, their_variance = estimate.mean[mask].sum(axis=0), estimate.variance[mask].sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return (total / theirs - 1, np.sqrt(variance + their_variance) / theirs,
                np.sqrt(their_variance) / theirs)


def chi_square_probability(value, freedom):
    """That chi-square of so many degrees of freedom exceeds `value` (Wilson, Hilferty 1931)."""
    if freedom == 0:
        return 1.0
    shift = 2 / (9 * freedom)
    z = ((value / freedom) ** (1 / 3) - (1 - shift)) / math.sqrt(shift)
    return 0.5 * math.erfc(z / math.sqrt(2))


def compare(reference, estimate):
    """{"means": {class: (difference, error, Mitsuba's own)}, "chi2", "freedom", "probability"}."""
    body = reference.coverage > 0.999
    mirror = body & grown(reference.mirrored)
    scattered = body & ~mirror
    means = {name: differences(reference.sums(mask), estimate, mask)
             for name, mask in (("scattered", scattered), ("mirror", mirror), ("all", body))
             if mask.any()}
    z = []
    parts = list(regions(scattered))
    for ours, region in zip(reference.pooled_sums(parts), parts):
        difference, error, own = differences(ours, estimate, region)
        usable = (own > 0) & (own < FEWEST)
        z.extend((difference / error)[usable])
    chi2 = float(np.sum(np.square(z)))
    return {"means": means, "chi2": chi2, "freedom": len(z),
            "probability": chi_square_probability(chi2, len(z))}


def report(result):
    """Prints the comparison; whether it is a success."""
    good = result["probability"] > 0.01
    for name, (difference, error, own) in result["means"].items():
        z = difference / error
        good &= name == "all" or bool(np.all((np.abs(z) <= 2) | ~(own < FEWEST)))
        cells = "  ".join(f"{100 * d:+7.3f} +- {100 * e:.3f} % ({s:+.1f})"
                          for d, e, s in zip(difference, error, z))
        print(f"{name:10} {cells}")
    print("regions    chi-square {chi2:.1f} of {freedom}, probability {probability:.3f}"
          .format(**result))
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("references", nargs="+", metavar="REF.exr")
    parser.add_argument("--case", required=True, help="a standard case by name, or its file")
    parser.add_argument("--medium", required=True, help="one of media.yaml, or {type: ..}")
    parser.add_argument("--seconds", type=passes.positive(float), default=60, help="of Mitsuba")
    arguments = parser.parse_args()
    reference = Reference(arguments.references)
    if len(arguments.references) < FEW_PICTURES:
        print(f"fewer than {FEW_PICTURES} pictures: standard errors are uncertain, of one picture "
              "too small", file=sys.stderr)
    case = scene.load_case(arguments.case, scene.find_material(arguments.medium))
    if reference.coverage.shape != (case.camera.height, case.camera.width):
        raise scene.InputError(f"{arguments.references[0]}: expected a picture of {case.file}")
    estimate = passes.accumulate(mitsuba_render.Mitsuba(case), case.camera,
                                 seconds=arguments.seconds)
    print(f"{case.file.stem} {arguments.medium}: reference over Mitsuba ({estimate.spp} spp), "
          "R, G, B; in brackets: standard errors")
    return 0 if report(compare(reference, estimate)) else 1


if __name__ == "__main__":
    sys.exit(passes.run(main))
