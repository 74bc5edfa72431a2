#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Total diffuse reflectances of the presets of Jensen et al. 2001: as printed, and under each model.

Prints the Markdown table of docs/PHYSICS.md. Needs the release build and nothing else.

    experiments/reflectances.py
"""
import json
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
MODELS = ["dipole", "better-dipole", "normalized-diffusion", "photon-beam-diffusion", "transport"]


def printed_reflectances():
    name, printed = None, {}
    for line in (ROOT / "data/materials.yaml").read_text().splitlines():
        if match := re.match(r"([\w-]+):$", line):
            name = match[1]
        elif match := re.match(r"  printed_reflectance: \[(.*)\]", line):
            printed[name] = [float(value) for value in match[1].split(",")]
    return printed


def totals(preset):
    command = [ROOT / "build/release/bin/tallow-material", preset, "--json"]
    models = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["models"]
    return [models[model]["total_reflectance"] for model in MODELS]


def cell(rgb, digits):
    return " ".join(f"{value:.{digits}f}" for value in rgb)


def main():
    print("| preset | printed | " + " | ".join(MODELS) + " |")
    print("|---" * (len(MODELS) + 2) + "|")
    for preset, printed in sorted(printed_reflectances().items()):
        print(f"| {preset} | {cell(printed, 2)} | "
              + " | ".join(cell(rgb, 3) for rgb in totals(preset)) + " |")


if __name__ == "__main__":
    main()
