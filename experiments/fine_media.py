#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sampling error of the exitance in denser and denser media, the samples staying where they are.

A ball (radius 10 mm), a cube (18 mm) and the bunny (18 mm) in marble and skim milk, sampled 0.35 mm
apart, under a square lamp and under a point light. The medium's coefficients are multiplied so that
the spacing is 0.35 to 31 times the smallest mean free path; what is compared with has 256 times the
samples (and the same treatment, where even these are too far apart). Writes into docs/results:

    fine_media.csv   a row a scene, density and method: plain sum, smoothed profile alone, ours
    fine_media.png   relRMSE against spacing / mean free path
    fine_media_pictures.png   bunny and cube, mean free path 0.035 mm: coarse, 256 times the samples

Needs the release build (./run build), the scanned bunny (./run fetch), and
`pip install numpy matplotlib pillow`. Takes some ten minutes and 0.5 GB in out/fine_media.

    experiments/fine_media.py [--models M,...] [--output DIR] [--build DIR]
"""
import argparse
import csv
import pathlib
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (after the choice of a backend without a display)

ROOT = pathlib.Path(__file__).resolve().parent.parent
WORK = ROOT / "out" / "fine_media"
SPACING, FINE = 0.35, 0.35 / 16  # mm
# Smallest mean free path of the preset in mm.
PRESETS = {"marble": 1 / 3.0071, "skimmilk": 1 / 1.9142}
RATIOS = [0.35, 1, 3, 10, 30]  # spacing / smallest mean free path
OBJECTS = {
    "ball": ("{shape: sphere, center: [0, 10, 0], radius: 10, material: body}", 10, 21),
    "cube": ("{shape: cube, center: [0, 9, 0], size: [18, 18, 18], material: body}", 9, 25),
    "bunny": (f"{{shape: mesh, file: {ROOT}/data/fetched/bunny.off, material: body, normals: smooth, "
              "transform: [{scale: 20}, {translate: [0, 9.87, 0]}]}", 9, 20),
}
LIGHTS = {
    "quad": "{type: quad, position: [-34, 46, 30], look_at: [0, 10, 0], size: [16, 16], "
            "radiance: [20, 20, 20], group: key}",
    "point": "{type: point, position: [-30, 44, 16], intensity: [40000, 40000, 40000], group: key}",
}
SCENE = """unit: mm
cameras:
  main: {{type: perspective, position: [14, 26, 62], look_at: [0, {y}, 0], fov_deg: {fov},
         resolution: [256, 256]}}
materials:
  body: {{type: subsurface, preset: marble, single_scattering: off}}
  table: {{type: diffuse, reflectance: [0.2, 0.2, 0.2]}}
objects:
  - {object}
  - {{shape: plane, point: [0, 0, 0], normal: [0, 1, 0], material: table}}
lights:
  - {light}
"""
METHODS = {"plain": "C1", "smoothed": "C0", "ours": "C2"}
STYLES = {"quad": "-", "point": "--"}


def make_scene(name, light):
    thing, y, fov = OBJECTS[name]
    scene = WORK / f"{name}_{light}.yaml"
    scene.write_text(SCENE.format(y=y, fov=fov, object=thing, light=LIGHTS[light]))
    return scene


def make_cache(options, scene, preset, spacing):
    """Depends on the index of refraction only, so that presets share caches where theirs agrees."""
    cache = scene.with_name(f"{scene.stem}_{preset}_{spacing:.3g}.tallow")
    subprocess.run([options.build / "bin/tallow-precompute", scene, "-o", cache, "--spacing",
                    f"{spacing:.9g}", "--quiet", "--light-samples", "64", "--set",
                    f"materials.body.preset={preset}"],
                   check=True)
    return cache


def measure(options, scene, preset, model, coarse, fine):
    densities = ",".join(f"{ratio * PRESETS[preset] / SPACING:.6g}" for ratio in RATIOS)
    result = subprocess.run(
        [options.build / "experiments/fine_media/fine-media-sweep", scene, coarse, fine,
         "--densities", densities, "--set", f"materials.body.preset={preset}",
         "--set", f"materials.body.model={model}", "--quiet"],
        check=True, stdout=subprocess.PIPE, text=True)
    return [dict(row, preset=preset) for row in csv.DictReader(result.stdout.splitlines())]


def write(rows, name):
    with open(name, "w", newline="") as file:
        writer = csv.DictWriter(file, ["preset", *[k for k in rows[0] if k != "preset"]],
                                lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def plot(rows, model, file):
    figure, axes = pyplot.subplots(1, len(OBJECTS), figsize=(13, 4), sharey=True)
    for axis, name in zip(axes, OBJECTS):
        for light, style in STYLES.items():
            for method, color in METHODS.items():
                points = sorted((float(r["h_per_mfp"]), float(r["relRMSE"])) for r in rows
                                if r["scene"] == f"{name}_{light}" and r["method"] == method
                                and r["preset"] == "marble" and r["model"] == model)
                axis.loglog(*zip(*points), style, color=color, marker="o", markersize=3,
                            label=f"{method}, {light} light")
        axis.set_title(name)
        axis.set_xlabel("spacing / smallest mean free path")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("sampling error, relRMSE")
    axes[-1].legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(file, dpi=110)


def render(options, scene, cache):
    picture = cache.with_suffix(".png")
    factor = 10 * PRESETS["marble"] / SPACING
    coefficients = [[round(factor * x, 6) for x in triple]
                    for triple in ([2.19, 2.62, 3.0], [0.0021, 0.0041, 0.0071])]
    subprocess.run([options.build / "bin/tallow-render", scene, "--cache", cache, "-o", picture,
                    "--quiet", "--exposure", "-1", "--set",
                    "materials.body={type: subsurface, sigma_s_prime: %s, sigma_a: %s, eta: 1.5, "
                    "single_scattering: off}" % tuple(coefficients)], check=True)
    return pyplot.imread(picture)


def show(pictures, file):
    figure, axes = pyplot.subplots(1, len(pictures), figsize=(4 * len(pictures), 4.2))
    for axis, (title, picture) in zip(axes, pictures):
        axis.imshow(picture)
        axis.set_title(title, fontsize=9)
        axis.axis("off")
    figure.tight_layout()
    figure.savefig(file, dpi=80)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", default="transport,dipole")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/results")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    options.output.mkdir(parents=True, exist_ok=True)
    rows, pictures = [], []
    models = options.models.split(",")
    for name in OBJECTS:
        for light in LIGHTS:
            scene = make_scene(name, light)
            for preset in PRESETS:
                print(f"{name}, {light} light, {preset}", file=sys.stderr, flush=True)
                caches = [make_cache(options, scene, preset, h) for h in (SPACING, FINE)]
                for model in models:
                    rows += measure(options, scene, preset, model, *caches)
                if preset == "marble" and (name, light) in (("bunny", "point"), ("cube", "quad")):
                    for h, cache in zip((SPACING, FINE), caches):
                        pictures.append((f"{name}, samples {h:.2g} mm apart",
                                         render(options, scene, cache)))
                for cache in caches:
                    cache.unlink()
                write(rows, options.output / "fine_media.csv")
    plot(rows, models[0], options.output / "fine_media.png")
    show(pictures, options.output / "fine_media_pictures.png")


if __name__ == "__main__":
    main()
