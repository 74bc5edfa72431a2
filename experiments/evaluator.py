#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error and time of the sums over samples: ours, certified, and the classical criterion.

Makes caches of 50k to 5M samples, runs build/release/experiments/evaluator/evaluator-sweep on them
and writes into docs/results:

    evaluator.csv          a row a setting; the sweep's columns after the wanted number of samples
                           (target_samples) and the camera rays a pixel (rays)
    evaluator_speedup.md   time at equal measured error, interpolated between settings
    evaluator_*.png        error against time and against evaluations; time against samples, points
    evaluator_machine.txt  where, from what and by which command

busy is the number of cores that the fastest run had: if below threads, times mean little. relRMSE,
p99 and max are errors against the plain sum in double, at points drawn with a fixed seed.
Criteria: `error` is PointSum::evaluate, `certified` PointSum::certify, `solid-angle` the traversal
of [JB02] with our table of the kernel, `formula` the same with the dipole's formula in float at each
node, as published implementations have it. The last two skip settings that would take longer than
--budget seconds.

Needs the release build (./run build), the scanned meshes (./run fetch), and
`pip install numpy matplotlib pyyaml`. The whole takes hours; --standard a quarter of an hour; --quick
takes less than two minutes and writes to out/evaluator/quick.

    experiments/evaluator.py [--quick | --standard] [--budget SECONDS] [--output DIR] [--build DIR]
    experiments/evaluator.py --plot-only [--output DIR]
"""
import argparse
import csv
import datetime
import os
import pathlib
import platform
import subprocess
import sys

import matplotlib
import numpy

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (after the choice of a backend without a display)

from harness import fits, programs  # noqa: E402
from harness.sweeps import evaluator_sweep  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
WORK = ROOT / "out" / "evaluator"
FULL = {
    "scenes": ["bunny", "armadillo"],
    "materials": ["marble", "skimmilk"],
    "models": ["transport", "dipole"],
    "samples": [50_000, 200_000, 1_000_000, 5_000_000],
    "tolerances": [0.1, 0.05, 0.03, 0.01, 0.003, 0.001, 0.0003, 0.0001],
    "certify": [0.1, 0.03, 0.01, 0.003, 0.001, 0.0003],
    "solid_angles": [0.6, 0.3, 0.18, 0.06, 0.018, 0.006, 0.0018, 0.0006],
    "rays": [2, 4, 8, 16],
    "repeat": 3,
}
QUICK = FULL | {
    "scenes": ["bunny"],
    "materials": ["marble"],
    "models": ["dipole"],
    "samples": [200_000],
    "tolerances": [0.1, 0.01, 0.001],
    "certify": [0.01],
    "solid_angles": [0.6, 0.06, 0.009],
    "rays": [4],
    "repeat": 2,
}
STANDARD = FULL | {
    "models": ["dipole"],
    "samples": [50_000, 200_000, 1_000_000],
    "tolerances": [0.1, 0.03, 0.01, 0.003, 0.001, 0.0003],
    "certify": [0.03, 0.01, 0.003],
    "solid_angles": [0.6, 0.18, 0.06, 0.018, 0.006],
    "repeat": 2,
}
STUDIED_SAMPLES = 200_000  # where points and threads are varied
REFERENCE_PAIRS = 2e9  # of point, sample and channel: some 10 s for a run's reference
COLORS = {"error": "C0", "certified": "C2", "solid-angle": "C1", "formula": "C3"}
MARKERS = "osD^v"


def say(text):
    print(text, file=sys.stderr, flush=True)


def material_flags(material, model):
    return ["--set", f"materials.marble.preset={material}", "--set",
            f"materials.marble.model={model}", "--set", "materials.marble.single_scattering=off"]


# --- caches ----------------------------------------------------------------------------------

def make_cache(options, scene, material, wanted):
    """The cache for a scene; an old one is used again if nothing it was made from has changed."""
    cache = WORK / f"{scene}_{material}_{wanted}.tallow"
    sources = [ROOT / f"scenes/{scene}.yaml", options.build / "bin/tallow-precompute"]
    if not cache.exists() or any(s.stat().st_mtime > cache.stat().st_mtime for s in sources):
        say(f"{cache.name}")
        programs.run("tallow-precompute", ROOT / f"scenes/{scene}.yaml", "-o", cache, "--points",
                     wanted, *material_flags(material, "dipole"), bin=options.build / "bin")
    return cache


# --- measurements ----------------------------------------------------------------------------

class Sweeper:
    """Runs evaluator-sweep and writes its rows to a CSV file as they come."""

    def __init__(self, options, settings, file):
        self.options, self.settings, self.file = options, settings, file
        self.writer = None

    def run(self, scene, cache, material, model, samples, criterion, accuracy, certify=(), rays=1,
            threads=0):
        say(f"  {scene} {material} {model} {samples} samples, {rays} rays: {criterion}")
        reference = max(200, min(2000, int(REFERENCE_PAIRS / 3 / samples)))
        rows, _ = evaluator_sweep(
            ROOT / f"scenes/{scene}.yaml", cache, *material_flags(material, model),
            criterion=criterion, accuracy=accuracy, certify=certify, samples=rays,
            reference=reference, repeat=self.settings["repeat"], threads=threads,
            budget=self.options.budget if criterion in ("solid-angle", "formula") else None,
            build=self.options.build)
        for row in rows:
            self.write({"target_samples": samples, "rays": rays} | row)

    def write(self, row):
        if self.writer is None:
            self.writer = csv.DictWriter(self.file, list(row), lineterminator="\n")
            self.writer.writeheader()
        self.writer.writerow(row)
        self.file.flush()


def measure_accuracy(sweeper, scene, cache, material, model, samples):
    s = sweeper.settings
    sweeper.run(scene, cache, material, model, samples, "error", s["tolerances"], s["certify"])
    sweeper.run(scene, cache, material, model, samples, "solid-angle", s["solid_angles"])
    if model == "dipole":
        sweeper.run(scene, cache, material, model, samples, "formula", s["solid_angles"])


def measure_points_and_threads(sweeper, scene, cache, material, model, samples):
    case = (scene, cache, material, model, samples)
    for rays in sweeper.settings["rays"]:
        sweeper.run(*case, "error", [0.01, 0.001], [0.01], rays=rays)
        sweeper.run(*case, "solid-angle", [0.06], rays=rays)
    threads = 1
    while threads < os.cpu_count():
        sweeper.run(*case, "error", [0.01, 0.001], [0.01], threads=threads)
        sweeper.run(*case, "solid-angle", [0.06], threads=threads)
        threads *= 2


def measure(options, settings):
    WORK.mkdir(parents=True, exist_ok=True)
    with open(options.output / "evaluator.csv", "w", newline="") as file:
        sweeper = Sweeper(options, settings, file)
        for scene in settings["scenes"]:
            for material in settings["materials"]:
                for samples in settings["samples"]:
                    cache = make_cache(options, scene, material, samples)
                    for model in settings["models"]:
                        measure_accuracy(sweeper, scene, cache, material, model, samples)
        # Points and threads matter in the same way everywhere: once is enough.
        cache = make_cache(options, "bunny", "marble", STUDIED_SAMPLES)
        measure_points_and_threads(sweeper, "bunny", cache, "marble", "dipole", STUDIED_SAMPLES)


def text_of(*command):
    try:
        return subprocess.run(command, capture_output=True, text=True, cwd=ROOT,
                              check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def describe_machine(options):
    cpu = [line.split(":", 1)[1].strip() for line in text_of("lscpu").splitlines()
           if line.startswith("Model name")]
    dirty = " with local changes" if text_of("git", "status", "--porcelain", "-uno") else ""
    compiler = "unknown"
    cache = options.build / "CMakeCache.txt"
    for line in cache.read_text().splitlines() if cache.exists() else []:
        if line.startswith("CMAKE_CXX_COMPILER:"):
            compiler = text_of(line.split("=", 1)[1], "--version").splitlines()[0]
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return "\n".join([
        f"date      {datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d %H:%M} UTC",
        f"cpu       {cpu[0] if cpu else platform.processor()}, {os.cpu_count()} threads",
        f"memory    {memory:.0f} GiB",
        f"load      {os.getloadavg()[1]:.2f} over the 5 minutes before",
        f"compiler  {compiler}",
        f"commit    {text_of('git', 'rev-parse', 'HEAD')}{dirty}",
        f"command   {' '.join([pathlib.Path(sys.argv[0]).name, *sys.argv[1:]])}", ""])


# --- results ---------------------------------------------------------------------------------

def read_rows(file):
    rows = []
    with open(file, newline="") as stream:
        for row in csv.DictReader(stream):
            for key, value in row.items():
                try:
                    row[key] = float(value)
                except ValueError:
                    pass
            row["time"] = row["grouping_s"] + row["evaluation_s"]
            rows.append(row)
    return rows


def select(rows, **wanted):
    return [r for r in rows if all(r[key] == value for key, value in wanted.items())]


def distinct(rows, *keys):
    """Combinations of values, in the order in which they come."""
    return list(dict.fromkeys(tuple(r[key] for key in keys) for r in rows))


def main_study(rows):
    """One ray a pixel, all threads: what is compared between scenes, materials and sizes."""
    return select(rows, rays=1, threads=max(r["threads"] for r in rows))


def unique_settings(rows):
    """Settings measured in more than one study count once."""
    return list({(r["criterion"], r["setting"]): r for r in reversed(rows)}.values())[::-1]


def time_at_error(rows, error):
    """Seconds at a measured relRMSE, logarithms interpolated; None outside of what was measured."""
    rows = unique_settings(rows)
    return fits.y_at([r["relRMSE"] for r in rows], [r["time"] for r in rows], error)


def disturbance(rows):
    """A sentence about rows whose threads did not have a core each, or nothing."""
    count = sum(r["busy"] < 0.9 * r["threads"] and r["evaluation_s"] > 0.02 for r in rows)
    if count == 0:
        return ""
    return (f"Disturbed: in {count} of {len(rows)} rows of the CSV `busy`, CPU seconds a second, is "
            "more than a tenth below `threads`; something else was running.")


def write_speedups(rows, note, file):
    head = ["scene", "material", "model", "lit samples", "relRMSE", "error, s", "solid-angle, s",
            "formula, s", "times solid-angle", "times formula"]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for case in distinct(rows, "scene", "material", "model", "lit_samples"):
        of_case = select(rows, **dict(zip(("scene", "material", "model", "lit_samples"), case)))
        for error in (0.01, 0.001):
            seconds = [time_at_error(select(of_case, criterion=c), error)
                       for c in ("error", "solid-angle", "formula")]
            cells = [*case[:3], f"{case[3]:.0f}", f"{error:g}"]
            cells += [f"{s:.3g}" if s else "" for s in seconds]
            cells += [f"{s / seconds[0]:.1f}" if s and seconds[0] else "" for s in seconds[1:]]
            lines.append("| " + " | ".join(cells) + " |")
    file.write_text("\n".join([*lines, *(["", note] if note else [])]) + "\n")


def finish_plot(figure, file):
    figure.tight_layout()
    figure.savefig(file, dpi=110)
    pyplot.close(figure)
    say(f"wrote {file}")


def panels(rows, *keys):
    """A figure with a panel for each combination of keys, and the rows that belong to it."""
    cases = distinct(rows, *keys)
    columns = min(4, len(cases))
    lines = -(-len(cases) // columns)
    figure, axes = pyplot.subplots(lines, columns, figsize=(5 * columns, 4.2 * lines),
                                   squeeze=False)
    for axis in axes.flat[len(cases):]:
        axis.set_visible(False)
    result = []
    for axis, case in zip(axes.flat, cases):
        axis.set(xscale="log", yscale="log", title=", ".join(map(str, case)))
        axis.grid(True, which="major", alpha=0.4)
        result.append((axis, select(rows, **dict(zip(keys, case)))))
    return figure, result


def plot_error(rows, against, label, file):
    figure, parts = panels(rows, "scene", "material", "model")
    sizes = [size for (size,) in distinct(rows, "target_samples")]
    for axis, part in parts:
        for criterion, size in distinct(part, "criterion", "target_samples"):
            line = unique_settings(select(part, criterion=criterion, target_samples=size))
            axis.plot([r[against] for r in line], [r["relRMSE"] for r in line],
                      color=COLORS[criterion], marker=MARKERS[sizes.index(size)], markersize=4,
                      linewidth=1, label=f"{criterion}, {size:.0f} samples")
        axis.set(xlabel=label, ylabel="relRMSE")
    parts[0][0].legend(fontsize=6)
    finish_plot(figure, file)


def plot_time(rows, keys, against, label, file):
    """Time against a size, with the exponent of a fitted power."""
    figure, parts = panels(rows, *keys)
    for axis, part in parts:
        for criterion, setting in sorted(distinct(part, "criterion", "setting")):
            line = sorted(select(part, criterion=criterion, setting=setting),
                          key=lambda r: r[against])
            x = numpy.array([r[against] for r in line])
            y = numpy.array([r["time"] for r in line])
            fit = ""
            if len(set(x)) > 1:
                fit = f", power {numpy.polyfit(numpy.log(x), numpy.log(y), 1)[0]:.2f}"
            axis.plot(x, y, color=COLORS[criterion], marker="o", markersize=4, linewidth=1,
                      linestyle="-" if setting in (0.01, 0.06) else "--",
                      label=f"{criterion} {setting:g}{fit}")
        axis.set(xlabel=label, ylabel="grouping and evaluation, s")
        axis.legend(fontsize=6)
    finish_plot(figure, file)


def plot(options):
    rows = read_rows(options.output / "evaluator.csv")
    compared = main_study(rows)
    write_speedups(compared, disturbance(rows), options.output / "evaluator_speedup.md")
    plot_error(compared, "time", "grouping and evaluation, s",
               options.output / "evaluator_error_time.png")
    plot_error(compared, "evaluations_per_point", "kernel evaluations a point, three channels",
               options.output / "evaluator_error_evaluations.png")
    shown = [r for r in compared if (r["criterion"] in ("error", "certified")
                                     and r["setting"] in (0.01, 0.001))
             or (r["criterion"] in ("solid-angle", "formula") and r["setting"] in (0.06, 0.006))]
    plot_time(shown, ("scene", "material", "model"), "lit_samples", "lit samples",
              options.output / "evaluator_time_samples.png")
    by_points = [r for r in select(rows, scene="bunny", material="marble", model="dipole",
                                   target_samples=STUDIED_SAMPLES, threads=compared[0]["threads"])
                 if r["setting"] in ((0.01, 0.001) if r["criterion"] == "error" else (0.01, 0.06))
                 and r["criterion"] != "formula"]
    plot_time(by_points, ("scene", "material", "model"), "points", "points",
              options.output / "evaluator_time_points.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="one scene, few settings")
    parser.add_argument("--standard", action="store_true",
                        help="the dipole, up to a million samples: a quarter of an hour")
    parser.add_argument("--plot-only", action="store_true", help="from the CSV that is there")
    parser.add_argument("--budget", type=float, default=None,
                        help="seconds a classical setting may take (60; 20 if quick, 8 if standard)")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--output", type=pathlib.Path)
    options = parser.parse_args()
    options.budget = options.budget or (20 if options.quick else 8 if options.standard else 60)
    options.build = options.build.resolve()
    options.output = options.output or (WORK / "quick" if options.quick
                                        else ROOT / "docs/results")
    options.output.mkdir(parents=True, exist_ok=True)
    if not options.plot_only:
        machine = describe_machine(options)
        measure(options, QUICK if options.quick else STANDARD if options.standard else FULL)
        (options.output / "evaluator_machine.txt").write_text(machine)
    plot(options)
    print((options.output / "evaluator_speedup.md").read_text(), end="")


if __name__ == "__main__":
    main()
