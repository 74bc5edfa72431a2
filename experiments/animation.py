#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What does a frame of an animation cost? The turntable of the bunny, 256 x 256, one ray a pixel.

Renders 36 frames of camera `turn` of scenes/bunny.yaml in one process; then some of them each by a
process of its own; then each by pass one and pass two from nothing. Compares the pictures byte by
byte. Prints seconds a frame as a Markdown table and writes docs/results/animation.csv: with all
light, and with settings.bounces=0. Needs the release build and the scanned meshes (./run fetch).
Times compare only if the machine has nothing else to do.

    experiments/animation.py [--every K]    only every K-th frame by itself [default: 6]
"""
import argparse
import csv
import json
import pathlib
import statistics
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "animation"
SCENE = ROOT / "scenes/bunny.yaml"
FRAMES = 36
VARIANTS = {"all light": [], "without indirect light": ["--set", "settings.bounces=0"]}


def run(program, *arguments):
    """Wall time of a process, s."""
    command = [ROOT / "build/release/bin" / program, SCENE, *arguments, "--quiet"]
    start = time.monotonic()
    subprocess.run(list(map(str, command)), check=True)
    return time.monotonic() - start


def render(cache, frames, output, *arguments):
    return run("tallow-render", "--cache", cache, "--camera", "turn", "--samples", 1, "--frames",
               frames, "-o", output, *arguments)


def render_together(flags):
    """Seconds of the process, of each frame in it, and of what comes before the first."""
    stats = OUT / "stats.json"
    process = render(OUT / "cache.tallow", f"0-{FRAMES - 1}", OUT / "together_##.exr", "--stats",
                     stats, *flags)
    frames = [frame["seconds"] for frame in json.loads(stats.read_text())["frames"]]
    return process, frames, process - sum(frames)


def require_same(frame):
    together, alone = OUT / f"together_{frame:02}.exr", OUT / "alone.exr"
    if together.read_bytes() != alone.read_bytes():
        raise SystemExit(f"{together} differs from {alone}")


def measure(variant, flags, every):
    """Rows: what, median, least and most seconds a frame."""
    run("tallow-precompute", "-o", OUT / "cache.tallow", *flags)
    process, frames, before = render_together(flags)
    alone, from_nothing = [], []
    for frame in range(0, FRAMES, every):
        alone.append(render(OUT / "cache.tallow", frame, OUT / "alone.exr", *flags))
        require_same(frame)
        pass_one = run("tallow-precompute", "-o", OUT / "own.tallow", *flags)
        (OUT / "own.tallow").unlink()  # or its direct light would be kept
        from_nothing.append(pass_one + alone[-1])
    rows = {"frame within one process": frames, "loading and preparing, once": [before],
            "one process for all, a frame": [process / FRAMES],
            "a process for each frame": alone, "pass one and pass two for each frame": from_nothing}
    return [[variant, what, f"{statistics.median(s):.3f}", f"{min(s):.3f}", f"{max(s):.3f}"]
            for what, s in rows.items()]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--every", type=int, default=6, metavar="K")
    every = parser.parse_args().every
    OUT.mkdir(parents=True, exist_ok=True)
    rows = [row for variant, flags in VARIANTS.items() for row in measure(variant, flags, every)]
    header = ["light", "what", "median s", "least s", "most s"]
    print("| " + " | ".join(header) + " |\n" + "|---" * len(header) + "|")
    for row in rows:
        print("| " + " | ".join(row) + " |")
    with open(ROOT / "docs/results/animation.csv", "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([header, *rows])


if __name__ == "__main__":
    main()
