#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What does a frame of an animation cost? The turntable of the bunny, 256 x 256, one ray a pixel.

Renders 36 frames of camera `turn` of scenes/bunny.yaml in one process; then some of them each by a
process of its own; then each by pass one and pass two from nothing. Compares the pictures byte by
byte. Prints medians a frame as a Markdown table and writes docs/results/animation.csv: with all
light, and with settings.bounces=0. Needs the release build and the scanned meshes (./run fetch).
Wall times compare only if the machine has nothing else to do; processor times nearly always do.

    experiments/animation.py [--every K]    only every K-th frame by itself [default: 6]
"""
import argparse
import csv
import json
import pathlib
import resource
import subprocess
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "animation"
SCENE = ROOT / "scenes/bunny.yaml"
FRAMES = 36
VARIANTS = {"all light": [], "without indirect light": ["--set", "settings.bounces=0"]}


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run(program, *arguments):
    """Wall and processor time of a process, s."""
    command = [ROOT / "build/release/bin" / program, SCENE, *arguments, "--quiet"]
    start, processor = time.monotonic(), processor_seconds()
    subprocess.run(list(map(str, command)), check=True)
    return np.array([time.monotonic() - start, processor_seconds() - processor])


def render(cache, frames, output, *arguments):
    return run("tallow-render", "--cache", cache, "--camera", "turn", "--samples", 1, "--frames",
               frames, "-o", output, *arguments)


def render_together(flags):
    """Times of the process, and the wall time of what comes before its first frame."""
    stats = OUT / "stats.json"
    process = render(OUT / "cache.tallow", f"0-{FRAMES - 1}", OUT / "together_##.exr", "--stats",
                     stats, *flags)
    summary = json.loads(stats.read_text())
    return process, summary["seconds"]["total"] - sum(f["seconds"] for f in summary["frames"])


def require_same(frame):
    together, alone = OUT / f"together_{frame:02}.exr", OUT / "alone.exr"
    if together.read_bytes() != alone.read_bytes():
        raise SystemExit(f"{together} differs from {alone}")


def measure(variant, flags, every):
    """Rows: light, how, wall and processor time of a frame."""
    run("tallow-precompute", "-o", OUT / "cache.tallow", *flags)
    process, before = render_together(flags)
    alone, pass_one = [], []
    for frame in range(0, FRAMES, every):
        alone.append(render(OUT / "cache.tallow", frame, OUT / "alone.exr", *flags))
        require_same(frame)
        (OUT / "own.tallow").unlink(missing_ok=True)  # or its direct light would be kept
        pass_one.append(run("tallow-precompute", "-o", OUT / "own.tallow", *flags))
    own = np.median(alone, axis=0)
    rows = {"one process for all": process / FRAMES, "a process for each frame": own,
            "pass one and pass two for each frame": own + np.median(pass_one, axis=0),
            "(loading and preparing, once)": [before, np.nan]}
    return [[variant, how, f"{wall:.3f}", "" if np.isnan(processor) else f"{processor:.3f}"]
            for how, (wall, processor) in rows.items()]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--every", type=int, default=6, metavar="K")
    every = parser.parse_args().every
    OUT.mkdir(parents=True, exist_ok=True)
    rows = [row for variant, flags in VARIANTS.items() for row in measure(variant, flags, every)]
    header = ["light", "how", "wall s", "processor s"]
    print("| " + " | ".join(header) + " |\n" + "|---" * len(header) + "|")
    for row in rows:
        print("| " + " | ".join(row) + " |")
    with open(ROOT / "docs/results/animation.csv", "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([header, *rows])


if __name__ == "__main__":
    main()
