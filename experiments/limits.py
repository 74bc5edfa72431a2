#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How far half-space profiles can be trusted: curvature and low albedo, as Markdown tables.

Curvature: a sphere without absorption under uniform light must return all that enters. The sum of pass
two over a sphere of radius a is the profile's plane integral up to the chord 2 a, so that the rest is
what it loses. Albedo: the models' total reflectances against transport's, all orders.

Needs the release build and nothing else.

    experiments/limits.py
"""
import json
import math
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
MODELS = ["dipole", "better-dipole", "normalized-diffusion", "transport"]
ETA = 1.3


def material(sigma_a, sigma_s_prime, radii=(1,)):
    command = [ROOT / "build/release/bin/tallow-material", "--json", "--eta", str(ETA),
               "--sigma-a", ",".join([f"{sigma_a:.9g}"] * 3),
               "--sigma-s-prime", ",".join([f"{sigma_s_prime:.9g}"] * 3),
               "--profile", ",".join(f"{r:.6g}" for r in radii)]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["models"]


def share_within(profile, end):
    """Integral of 2 pi r R dr from 0 to `end`, trapezoidal in log r."""
    rows = [(r, red) for r, red, _, _ in profile if r <= end]
    total = math.pi * rows[0][0] ** 2 * rows[0][1]  # flat below the first radius
    for (r0, f0), (r1, f1) in zip(rows, rows[1:]):
        total += math.pi * (f0 * r0 * r0 + f1 * r1 * r1) * math.log(r1 / r0)
    return total


def curvature():
    radii = [10 ** (-4 + k / 200) for k in range(1401)]
    models = material(0, 1, radii)  # mean free path 1 mm
    print("| radius, mean free paths | " + " | ".join(MODELS) + " |")
    print("|---" * (len(MODELS) + 1) + "|")
    for radius in [2, 5, 10, 20, 50, 200]:
        shares = [share_within(models[model]["profile"], 2 * radius) for model in MODELS]
        print(f"| {radius} | " + " | ".join(f"{share:.3f}" for share in shares) + " |")


def albedo():
    print("| alpha' | transport | " + " | ".join(MODELS[:-1]) + " |")
    print("|---" * (len(MODELS) + 1) + "|")
    for alpha in [0.2, 0.5, 0.8, 0.9, 0.95, 0.99, 0.999]:
        models = material(1 - alpha, alpha)
        total = {model: models[model]["total_reflectance"][0] for model in MODELS}
        print(f"| {alpha} | {total['transport']:.4f} | "
              + " | ".join(f"{total[model] / total['transport'] - 1:+.1%}" for model in MODELS[:-1])
              + " |")


if __name__ == "__main__":
    curvature()
    print()
    albedo()
