#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Where does the time of a whole picture go? The bunny in marble, 512 x 512, one camera ray a pixel.

Runs tallow-precompute and tallow-render on scenes/bunny.yaml five times with default settings
(tolerance 1 %), prints the median of each phase as a Markdown table and writes
docs/results/whole.csv. Needs the release build and the scanned meshes (./run fetch). Times compare
only if the machine has nothing else to do: the spread between the fastest and the slowest run is
printed beside.

    experiments/whole.py [--runs N] [SCENE [FLAG ...]]
"""
import csv
import json
import pathlib
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "whole"


def run(program, *arguments):
    """Seconds by phase; `process` is the wall time of the whole process."""
    stats = OUT / "stats.json"
    command = [ROOT / "build/release/bin" / program, *arguments, "--quiet", "--stats", stats]
    start = time.monotonic()
    subprocess.run(list(map(str, command)), check=True)
    seconds = json.loads(stats.read_text())["seconds"]
    return {**seconds, "process": time.monotonic() - start}


def both(scene, flags):
    cache = OUT / "cache.tallow"
    one = run("tallow-precompute", scene, "-o", cache, *flags)
    two = run("tallow-render", scene, "--cache", cache, "-o", OUT / "image.exr", "--samples", 1,
              *flags)
    whole = {"both": {"process": one["process"] + two["process"]}}
    return {"precompute": one, "render": two, **whole}


def main():
    arguments = sys.argv[1:]
    count = 5
    if arguments[:1] == ["--runs"]:
        count, arguments = int(arguments[1]), arguments[2:]
    scene, flags = arguments[0] if arguments else ROOT / "scenes/bunny.yaml", arguments[1:]
    OUT.mkdir(parents=True, exist_ok=True)
    runs = [both(scene, flags) for _ in range(count)]
    rows = []
    for program in runs[0]:
        for phase in sorted(runs[0][program], key=lambda p: (p in ("total", "process"), p)):
            seconds = [run[program][phase] for run in runs]
            rows.append([program, phase, f"{statistics.median(seconds):.4f}",
                         f"{min(seconds):.4f}", f"{max(seconds):.4f}"])
    header = ["program", "phase", "median s", "least s", "most s"]
    print("| " + " | ".join(header) + " |\n" + "|---" * len(header) + "|")
    for row in rows:
        print("| " + " | ".join(row) + " |")
    if not arguments:
        (ROOT / "docs/results").mkdir(exist_ok=True)
        with open(ROOT / "docs/results/whole.csv", "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([header, *rows])


if __name__ == "__main__":
    main()
