#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Does --tolerance keep its promise? Measured error over tolerance, for every preset, model and N.

Renders the exitance of every shipped scene, and of a body with each preset of data/materials.yaml
(default spacing), with each model, and in marble with samples from a few to millions, with tolerances
0.1, 0.01 and 0.001, against the plain sum (--tolerance 0). Prints a Markdown table, writes
docs/results/tolerance.csv (if all is measured), and exits with 1 if any relRMSE is above its
tolerance. Needs the release build, the scanned meshes (./run fetch) and `pip install numpy OpenEXR`.

    experiments/tolerance.py [--quick | --scenes]
"""
import csv
import json
import pathlib
import re
import subprocess
import sys

import numpy
import OpenEXR

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "tolerance"
TOLERANCES = [0.1, 0.01, 0.001]
MODELS = ["dipole", "classic-dipole", "better-dipole", "normalized-diffusion", "photon-beam-diffusion",
          "transport"]
SCENE = """unit: mm
cameras:
  main: {{type: perspective, position: [-18, 60, 92], look_at: [0, 17, 0], fov_deg: 29,
         resolution: [{resolution}, {resolution}]}}
materials:
  body: {{type: subsurface, preset: {preset}, model: {model}, single_scattering: off}}
objects:
  - shape: mesh
    file: {mesh}
    material: body
    transform: [{{scale: 40.5}}, {{translate: [0, 19.98, 0]}}]
lights:
  - {{type: quad, position: [42, 62, -52], look_at: [0, 20, 0], size: [36, 36], radiance: [52, 50, 46]}}
  - {{type: point, position: [-30, 50, 60], intensity: [300, 500, 900]}}
"""


def run(program, *arguments):
    command = [ROOT / "build/release/bin" / program, *arguments, "--quiet"]
    subprocess.run(list(map(str, command)), check=True)


def exitance(file):
    with OpenEXR.File(str(file), separate_channels=True) as exr:
        channels = exr.channels()
        return numpy.stack([channels["exitance." + c].pixels for c in "RGB"], -1).astype(float)


def render(scene, cache, tolerance, *flags):
    image, stats = OUT / "image.exr", OUT / "stats.json"
    run("tallow-render", scene, "--cache", cache, "-o", image, "--stats", stats, "--samples", 1,
        "--aovs", "exitance", "--tolerance", tolerance, *flags)
    return exitance(image), json.loads(stats.read_text())["counts"]


def measure(preset, model, spacing, resolution):
    scene, cache = OUT / "scene.yaml", OUT / "cache.tallow"
    scene.write_text(SCENE.format(preset=preset, model=model, resolution=resolution,
                                  mesh=ROOT / "data/fetched/bunny.off"))
    run("tallow-precompute", scene, "-o", cache, "--light-samples", 4,
        *(["--spacing", spacing] if spacing else []))
    plain, _ = render(scene, cache, 0)
    body = plain.max(axis=2) > 0
    rows = []
    for tolerance in TOLERANCES:
        fast, counts = render(scene, cache, tolerance)
        error = numpy.sqrt(numpy.mean((fast[body] - plain[body]) ** 2)) / numpy.mean(plain[body])
        rows.append([preset, model, counts["lit_samples"], tolerance, f"{error:.3g}",
                     f"{error / tolerance:.2f}",
                     round(counts["evaluations"] / counts["exitance_points"])])
    return rows


def measure_scene(name):
    """A shipped scene as it is, but small, and without light scattered once."""
    scene, cache = ROOT / "scenes" / f"{name}.yaml", OUT / "cache.tallow"
    text = scene.read_text()
    camera = re.search(r"^cameras:\s*\n\s+(\w+):", text, re.MULTILINE).group(1)
    body = re.search(r"^\s+(\w+):\s*\{[^}]*type: subsurface", text, re.MULTILINE).group(1)
    flags = ["--set", f"cameras.{camera}.resolution=[96, 96]",
             "--set", f"materials.{body}.single_scattering=off"]
    run("tallow-precompute", scene, "-o", cache, "--light-samples", 4, *flags)
    plain, _ = render(scene, cache, 0, *flags)
    seen = plain.max(axis=2) > 0
    rows = []
    for tolerance in TOLERANCES:
        fast, counts = render(scene, cache, tolerance, *flags)
        error = numpy.sqrt(numpy.mean((fast[seen] - plain[seen]) ** 2)) / numpy.mean(plain[seen])
        rows.append([name, "of the scene", counts["lit_samples"], tolerance, f"{error:.3g}",
                     f"{error / tolerance:.2f}",
                     round(counts["evaluations"] / counts["exitance_points"])])
    return rows


def presets():
    text = (ROOT / "data/materials.yaml").read_text()
    return re.findall(r"^([a-z][a-z0-9-]*):", text, re.MULTILINE)


def cases(quick):
    for preset in presets()[:3] if quick else presets():
        yield preset, "transport", None, 32
    for model in MODELS[:2] if quick else MODELS:
        yield "marble", model, 0.2, 40
    for spacing in [60, 20, 6, 2, 0.6] + ([] if quick else [0.2, 0.06, 0.035]):
        yield "marble", "transport", spacing, 32 if spacing > 0.1 else 16


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    header = ["scene or preset", "model", "lit samples", "tolerance", "relRMSE", "of the tolerance",
              "evaluations a point"]
    rows = []
    print("| " + " | ".join(header) + " |\n" + "|---" * len(header) + "|")
    quick = "--quick" in sys.argv
    scenes = sorted(path.stem for path in (ROOT / "scenes").glob("*.yaml"))
    measurements = [lambda name=name: measure_scene(name) for name in scenes]
    if "--scenes" not in sys.argv:
        measurements += [lambda case=case: measure(*case) for case in cases(quick)]
    for measurement in measurements:
        for row in measurement():
            rows.append(row)
            print("| " + " | ".join(map(str, row)) + " |", flush=True)
    worst = max(rows, key=lambda row: float(row[5]))
    print(f"\nworst: {worst}", file=sys.stderr)
    if len(sys.argv) == 1:
        (ROOT / "docs/results").mkdir(exist_ok=True)
        with open(ROOT / "docs/results/tolerance.csv", "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([header, *rows])
    sys.exit(float(worst[5]) > 1)


if __name__ == "__main__":
    main()
