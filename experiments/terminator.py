#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Straight against refracted shadow rays of single scattering, on a marble ball lit from the side.

Prints the mean ratio of the two `single` layers by the cosine between normal and light, as a Markdown
table. Needs the release build and `pip install numpy OpenEXR`.

    experiments/terminator.py
"""
import pathlib
import subprocess

import numpy
import OpenEXR

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "terminator"
SCENE = """
cameras:
  main: {type: perspective, position: [0, 0, 100], look_at: [0, 0, 0], fov_deg: 12, resolution: [128, 128]}
materials:
  marble: {type: subsurface, preset: marble}
objects:
  - {shape: sphere, radius: 10, material: marble}
lights:
  - {type: directional, direction: [-1, 0, 0], irradiance: 1}
settings: {samples: 1}
"""
EDGES = [0, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9]


def run(program, *arguments):
    command = [ROOT / "build/release/bin" / program, *arguments, "--quiet"]
    subprocess.run(list(map(str, command)), check=True)


def render(scene, cache, connection):
    image = OUT / f"{connection}.exr"
    run("tallow-render", scene, "--cache", cache, "-o", image, "--aovs", "single,N",
        "--set", f"materials.marble.single_scattering={connection}")
    with OpenEXR.File(str(image), separate_channels=True) as exr:
        return {name: channel.pixels.astype(float) for name, channel in exr.channels().items()}


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    scene, cache = OUT / "scene.yaml", OUT / "scene.tallow"
    scene.write_text(SCENE)
    run("tallow-precompute", scene, "-o", cache)
    straight, exact = (render(scene, cache, name) for name in ("straight", "exact"))
    cosine, seen = straight["N.X"], straight["A"] > 0
    print("| cosine to the light | pixels | straight / exact |")
    print("|---|---|---|")
    for low, high in zip(EDGES, EDGES[1:]):
        ring = seen & (cosine >= low) & (cosine < high)
        ratio = straight["single.G"][ring].sum() / exact["single.G"][ring].sum()
        print(f"| {low} to {high} | {ring.sum()} | {ratio:.2f} |")


if __name__ == "__main__":
    main()
