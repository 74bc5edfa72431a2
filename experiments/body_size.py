#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What does the body-aware solve cost in large bodies, and what is it worth there?

Takes the sphere and the bunny in marble whose coefficients are scaled so that the figures are 10 to
100,000 mean free paths across (the longest edge of the box, the green channel), runs pass one and
diffusion-convergence with default settings, but without indirect light, and writes
docs/results/body_size.csv and the table of docs/BODY_AWARE.md. Where the automatic spacing asks for
more samples than --most, they are --most: beyond some size nothing else fits in memory. Seconds are
processor time of all threads, the least of --runs.

    ./run build && ./run fetch
    experiments/python experiments/body_size.py [--most N] [--runs N] [--sizes X ...]
"""
import argparse
import csv
import pathlib
import subprocess

import yaml

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAMS = ROOT / "build/release"
OUT = ROOT / "out/body_size"
TABLE = ROOT / "docs/results/body_size.csv"
PAGE = ROOT / "docs/BODY_AWARE.md"
MARKS = "<!-- table: experiments/body_size.py -->\n", "<!-- end -->"

FIGURES = {"sphere": 20.0, "bunny": 40.4}  # mm across
SIZES = [10, 30, 100, 300, 1000, 10_000, 100_000]  # mean free paths across
FIELDS = ["figure", "mean_free_paths_across", "samples", "spacing_mean_free_paths", "solved",
          "clusters", "operator_cpu_s", "solve_cpu_s", "megabytes", "iterations", "ratio_1",
          "ratio_99", "relRMSE_to_transport"]


def medium_of(figure, size):
    """The override that gives the figure a scaled marble, and its mean free path in green, mm."""
    marble = yaml.safe_load((ROOT / "data/materials.yaml").read_text())["marble"]
    green = 1 / (marble["sigma_s_prime"][1] + marble["sigma_a"][1])
    scale = size * green / FIGURES[figure]
    scaled = {key: [float(f"{scale * value:.6g}") for value in marble[key]]
              for key in ("sigma_s_prime", "sigma_a")}
    return (f"materials.body={{type: subsurface, sigma_s_prime: {scaled['sigma_s_prime']}, "
            f"sigma_a: {scaled['sigma_a']}, eta: {marble['eta']}, model: body-aware}}",
            green / scale)


def output_of(*command):
    return subprocess.run(list(map(str, command)), check=True, cwd=ROOT, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE).stdout


def plan(*command):
    """Numbers of the plan of pass one by name; none if samples do not fit in memory."""
    try:
        lines = output_of(*command, "--plan").splitlines()
    except subprocess.CalledProcessError:
        return {}
    rows = [line.split() for line in lines]
    return {row[0]: row[1] for row in rows if len(row) == 2}


def measure(figure, size, most, runs):
    scene = f"experiments/cases/{figure}.yaml"
    medium, mean_free_path = medium_of(figure, size)
    cache = OUT / f"{figure}-{size}.tallow"
    first = [PROGRAMS / "bin/tallow-precompute", scene, "--set", medium, "--bounces", 0]
    planned = plan(*first)
    if not planned or float(planned["samples"]) > most:
        first += ["--points", most]
        planned = plan(*first)
    output_of(*first, "-o", cache, "--quiet")
    second = [PROGRAMS / "experiments/diffusion/diffusion-convergence", scene, cache, "--set",
              medium, "--set", "settings.bounces=0", "--clusters", 0, "--quiet"]
    rows = [next(csv.DictReader(output_of(*second).splitlines())) for _ in range(runs)]
    cache.unlink()
    least = lambda key: min(float(row[key]) for row in rows)
    row, solved = rows[0], int(rows[0]["clusters"]) > 0
    return {
        "figure": figure, "mean_free_paths_across": size, "samples": planned["samples"],
        "spacing_mean_free_paths": f"{float(planned['objects[0].spacing_mm']) / mean_free_path:.3g}",
        "solved": row["solved"], "clusters": row["clusters"],
        "operator_cpu_s": f"{least('build_cpu_s'):.2f}" if solved else "0",
        "solve_cpu_s": f"{least('solve_cpu_s'):.2f}" if solved else "0",
        "megabytes": f"{float(row['megabytes']):.0f}", "iterations": row["iterations"],
        "ratio_1": f"{float(row['ratio_1']):.3g}", "ratio_99": f"{float(row['ratio_99']):.3g}",
        "relRMSE_to_transport": f"{float(row['transport']):.3g}"}


def table_row(row):
    if row["clusters"] == "0":
        cost = ["nothing", "-", "-", "-", "-", "-"]
    else:
        cost = [row["solved"], row["clusters"], f"{row['operator_cpu_s']} + {row['solve_cpu_s']}",
                row["megabytes"], row["iterations"], f"{row['ratio_1']} to {row['ratio_99']}"]
    return "| " + " | ".join([
        row["figure"], f"{int(row['mean_free_paths_across']):,}", f"{float(row['samples']):,.0f}",
        row["spacing_mean_free_paths"], *cost,
        f"{100 * float(row['relRMSE_to_transport']):.2g} %"]) + " |\n"


def table(rows):
    return ("| figure | mean free paths across | samples | spacing, mean free paths | solved | "
            "clusters | processor s: operator + one group | MB | GMRES steps | ratio | "
            "from transport |\n" + "|---" * 11 + "|\n" + "".join(map(table_row, rows)))


def write(rows):
    with open(TABLE, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    before, rest = PAGE.read_text().split(MARKS[0])
    _, after = rest.split(MARKS[1], 1)
    PAGE.write_text(before + MARKS[0] + table(rows) + MARKS[1] + after)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--most", type=int, default=1_000_000,
                        help="samples of a figure [default: 1,000,000]")
    parser.add_argument("--runs", type=int, default=2, help="of the solve [default: 2]")
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, metavar="X",
                        help="mean free paths; any but the default ones are only printed")
    arguments = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    rows = []
    for figure in FIGURES:
        for size in arguments.sizes:
            rows.append(measure(figure, size, arguments.most, arguments.runs))
            print(table_row(rows[-1]), end="", flush=True)
    if arguments.sizes == SIZES:
        write(rows)


if __name__ == "__main__":
    main()
