#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Everything against the plan: each shipped scene rendered as planned and with --everything.

    experiments/plan.py [--size 128] [--samples 4] [SCENE ...]

Compares the two pictures over the pixels that see a translucent body, in the layers' sum without
what mirrors show, and the seconds of both programs. Besides the shipped scenes two that give the plan
something to leave out. Writes docs/results/plan.csv and prints it.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import tempfile
import time

import numpy as np
import OpenEXR

ROOT = pathlib.Path(__file__).resolve().parent.parent
BIN = ROOT / "build/release/bin"
SHIPPED = sorted((ROOT / "scenes").glob("*.yaml"))

HEAD = """cameras:
  main: {type: perspective, position: [0, 6, 60], look_at: [0, 0, 0], fov_deg: 30, resolution: [128, 128]}
lights:
  - {type: directional, direction: [-1, -1, -1], irradiance: 3}
"""
EXTRA = {
    # scattering so forward that hardly anything comes back after one collision
    "forward_milk": HEAD + """materials:
  milk: {type: subsurface, sigma_s: 100, g: 0.98, sigma_a: [0.001, 0.002, 0.01], eta: 1.5}
objects:
  - {shape: sphere, center: [0, 0, 0], radius: 10, material: milk}
""",
    # mean free paths of nanometres: paint
    "paint": HEAD + """materials:
  paint: {type: subsurface, sigma_s_prime: 40000, sigma_a: [400, 800, 1600], eta: 1.5}
objects:
  - {shape: sphere, center: [0, 0, 0], radius: 10, material: paint}
""",
}


def render(scene, size, samples, folder, name, flags, sampling):
    cache, image, stats = (folder / f"{name}.{end}" for end in ("tallow", "exr", "json"))
    start = time.monotonic()
    subprocess.run([BIN / "tallow-precompute", scene, "-o", cache, "--quiet", *flags, *sampling],
                   check=True)
    subprocess.run([BIN / "tallow-render", scene, "--cache", cache, "-o", image, "--quiet",
                    "--samples", str(samples), "--aovs", "multiple,single,diffuse,exitance",
                    "--stats", stats, "--set", f"cameras.main.resolution=[{size}, {size}]", *flags],
                   check=True)
    seconds = time.monotonic() - start
    with OpenEXR.File(str(image), separate_channels=True) as file:
        channels = file.channels()
        picture = sum(np.stack([channels[f"{layer}.{c}"].pixels for c in "RGB"]).astype(np.float64)
                      for layer in ("multiple", "single", "diffuse"))
        body = np.stack([channels[f"exitance.{c}"].pixels for c in "RGB"]).max(axis=0) > 0
    plan = json.loads(stats.read_text())["plan"]["decisions"]
    return picture, body, seconds, [f"{d['subject']} {d['term']}" for d in plan
                                    if not d["computed"]]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", type=pathlib.Path, default=[])
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--samples", type=int, default=4)
    arguments = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        scenes = [(scene, []) for scene in arguments.scenes or SHIPPED]
        for name, text in EXTRA.items() if not arguments.scenes else ():
            path = folder / f"{name}.yaml"
            path.write_text(text)
            # samples as fine as the paint's mean free path would be 1e12
            scenes.append((path, ["--points", "300000"] if name == "paint" else []))
        for scene, sampling in scenes:
            run = lambda name, flags, points: render(scene, arguments.size, arguments.samples,
                                                     folder, name, flags, points)
            planned, _, planned_seconds, left_out = run("planned", [],
                                                        [] if "paint" in scene.stem else sampling)
            full, body, full_seconds, _ = run("everything", ["--everything"], sampling)
            difference = planned[:, body] - full[:, body]
            rms = np.sqrt(np.mean(difference**2)) / np.mean(full[:, body])
            rows.append([scene.stem, f"{rms:.2g}", f"{planned_seconds:.2f}", f"{full_seconds:.2f}",
                         "; ".join(left_out) or "nothing"])
            print(rows[-1], flush=True)
    out = ROOT / "docs/results/plan.csv"
    with out.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["scene", "rel_rmse", "seconds_planned", "seconds_everything", "left_out"])
        writer.writerows(rows)


if __name__ == "__main__":
    main()
