#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error of the exitance by the samples alone: cells against random points and blue noise.

Runs build/release/experiments/sampling/sampling-sweep and writes into docs/results:

    sampling.csv            a row a body, medium, model, kind of samples and number of them
    sampling_points.png     error against the number of samples
    sampling_time.png       error against the time that samples and their light take
    sampling_spacing.png    error of cells against their spacing in mean free paths
    sampling.md             the spacing at 1 %, interpolated, of every medium and model
    sampling_command.txt    where, and by which command

Bodies are 40 mm large and lit by parallel light. Media are marble, at 0.3 to 30 times its density,
and skim milk. Kinds of samples: `cells` are those of tallow-precompute; `random`, `blue-noise` (dart
throwing) carry equal areas; `voronoi` is blue noise with the areas of its Voronoi cells; `bands` are
the cells of a true sphere, in place of a mesh. The reference has 16 times the samples of the finest.
Dart throwing is written plainly: a good one would be some times faster.

Needs the release build (./run build), the scanned meshes (./run fetch), and
`pip install numpy matplotlib pyyaml`. Two to three minutes; --quick half a minute, into
out/sampling.

    experiments/sampling.py [--quick] [--output DIR] [--build DIR]
    experiments/sampling.py --plot-only [--output DIR]
"""
import argparse
import collections
import csv
import datetime
import os
import pathlib
import shlex
import sys

import matplotlib
import matplotlib.ticker
import numpy

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (after the choice of a backend without a display)

from harness.sweeps import sampling_sweep  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
KINDS = {"cells": "tab:blue", "bands": "tab:cyan", "voronoi": "tab:green",
         "blue-noise": "tab:orange", "random": "tab:red"}
# What to run: arguments of the sweep.
RUNS = [
    ["data/fetched/bunny.off", "--densities", "0.3,1,3,10,30"],
    ["data/fetched/armadillo.off", "--densities", "0.3,1,3", "--samples", "2000,8000,32000"],
    ["sphere", "--densities", "0.3,1,3", "--samples", "2000,8000,32000", "--methods",
     "cells,bands,random,blue-noise,voronoi"],
    ["data/fetched/bunny.off", "--preset", "skimmilk", "--densities", "0.3,1,3", "--methods", "cells"],
    ["data/fetched/bunny.off", "--densities", "0.3,1", "--methods", "cells", "--models",
     "dipole,better-dipole,normalized-diffusion,photon-beam-diffusion"],
]
QUICK = [["data/fetched/bunny.off", "--densities", "0.3,1,3", "--samples", "1000,4000,16000"]]


def sweep(build, runs):
    rows = []
    for body, *flags in runs:
        print("sampling-sweep", body, shlex.join(flags), file=sys.stderr)
        body = body if body == "sphere" else ROOT / body
        rows += sampling_sweep(body, *flags, build=build)[0]
    return rows


def number(row, key):
    return float(row[key])


def curves(rows, keys):
    """Rows grouped by the values of `keys`, each by growing number of samples."""
    groups = collections.defaultdict(list)
    for row in rows:
        groups[tuple(row[key] for key in keys)].append(row)
    for group in groups.values():
        group.sort(key=lambda row: number(row, "wished"))
    return groups


def plot_kinds(rows, x_of, x_label, file):
    rows = [row for row in rows if row["model"] == "transport" and row["preset"] == "marble"]
    panels = curves(rows, ["body", "density"])
    columns = 4
    lines = -(-len(panels) // columns)
    figure, axes = pyplot.subplots(lines, columns, figsize=(14, 3.3 * lines), squeeze=False)
    for axis in axes.flat[len(panels):]:
        axis.set_visible(False)
    for axis, ((body, density), panel) in zip(axes.flat, panels.items()):
        for (kind,), points in curves(panel, ["method"]).items():
            axis.loglog([x_of(row) for row in points], [number(row, "rel_rmse") for row in points],
                        "o-", color=KINDS[kind], label=kind, markersize=4)
        axis.set_title(f"{body}, marble x {density}", fontsize=10)
        axis.set_xlabel(x_label)
        axis.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
        axis.grid(True, which="major", alpha=0.4)
    for axis in axes[:, 0]:
        axis.set_ylabel("relRMSE")
    known = {label: line for axis in axes.flat
             for line, label in zip(*axis.get_legend_handles_labels())}
    axes.flat[0].legend(known.values(), known.keys(), fontsize=8)
    figure.tight_layout()
    figure.savefig(file, dpi=90)


def plot_spacing(rows, file):
    figure, axis = pyplot.subplots(figsize=(7, 5))
    cells = [row for row in rows if row["method"] == "cells"]
    for key, points in curves(cells, ["body", "preset", "density", "model"]).items():
        axis.loglog([number(r, "spacing_mm") / number(r, "mfp_mm") for r in points],
                    [number(r, "rel_rmse") for r in points], ".-", linewidth=0.8,
                    label=" ".join(key) if len(points) else "")
    axis.axhline(0.01, color="black", linewidth=0.6)
    axis.axvline(0.35, color="black", linewidth=0.6)
    axis.set_xlabel("spacing / smallest mean free path")
    axis.set_ylabel("relRMSE of cells")
    axis.legend(fontsize=5, ncols=2)
    axis.grid(True, which="major", alpha=0.4)
    figure.tight_layout()
    figure.savefig(file, dpi=110)


def spacing_at(points, error):
    """Spacing in mean free paths at which cells have this error, or None outside of the curve."""
    h = numpy.log([number(r, "spacing_mm") / number(r, "mfp_mm") for r in points])[::-1]
    e = numpy.log([number(r, "rel_rmse") for r in points])[::-1]
    if not e[0] < numpy.log(error) < e[-1] or numpy.any(numpy.diff(e) <= 0):
        return None
    return float(numpy.exp(numpy.interp(numpy.log(error), e, h)))


def write_spacings(rows, file):
    lines = ["Spacing of cells, in mean free paths of the smallest channel, at a relRMSE of:", "",
             "| body | medium | model | 3 % | 1 % | 0.3 % |", "|---|---|---|---|---|---|"]
    cells = [row for row in rows if row["method"] == "cells"]
    for (body, preset, density, model), points in curves(
            cells, ["body", "preset", "density", "model"]).items():
        found = [spacing_at(points, error) for error in (0.03, 0.01, 0.003)]
        if any(found):
            texts = [f"{x:.2f}" if x else "" for x in found]
            lines.append(f"| {body} | {preset} x {density} | {model} | {' | '.join(texts)} |")
    file.write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="half a minute, into out/sampling")
    parser.add_argument("--plot-only", action="store_true", help="draw the CSV that is there")
    parser.add_argument("--output", type=pathlib.Path)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    a = parser.parse_args()
    output = a.output or ROOT / ("out/sampling" if a.quick else "docs/results")
    output.mkdir(parents=True, exist_ok=True)
    table = output / "sampling.csv"
    if not a.plot_only:
        rows = sweep(a.build, QUICK if a.quick else RUNS)
        with open(table, "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        (output / "sampling_command.txt").write_text(
            f"date      {datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d %H:%M} UTC\n"
            f"threads   {os.cpu_count()}\nload      {os.getloadavg()[1]:.2f} over the 5 minutes before\n"
            f"command   {shlex.join(sys.argv)}\n")
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    plot_kinds(rows, lambda row: number(row, "samples"), "samples", output / "sampling_points.png")
    plot_kinds(rows, lambda row: number(row, "seconds_sample") + number(row, "seconds_light"),
               "seconds for samples and light", output / "sampling_time.png")
    plot_spacing(rows, output / "sampling_spacing.png")
    write_spacings(rows, output / "sampling.md")


if __name__ == "__main__":
    main()
