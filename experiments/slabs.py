#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The body-aware model in plates, against transport.

    experiments/python experiments/slabs.py [--eta ETA] [--albedo A ...] [--thickness T ...]
                                            [--incidence DEGREES]

Plates of T mean free paths (1 mm), lit at right angles or DEGREES from that; prints how far off is what leaves after two
scatterings or more: on the lit side and on the other, seen at right angles and at 45 degrees, in
per cent of transport (slab_transport.py).
"""
import argparse
import math
import pathlib
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "experiments"))

from harness import programs  # noqa: E402
from harness.images import read_image  # noqa: E402
from slab_transport import Slab  # noqa: E402

FAR = 300      # of the camera, mm
SIDE = 40      # of the plate, mm
COS_45 = 0.5 ** 0.5
VIEWS = {"lit": (1, 1), "lit 45": (COS_45, 1), "other": (1, -1), "other 45": (COS_45, -1)}

SCENE = """unit: mm
cameras: {{{cameras}}}
materials:
  body: {{type: subsurface, sigma_s_prime: [{s}, {s}, {s}], sigma_a: [{a}, {a}, {a}], eta: {eta}, model: {model}}}
objects: [{{shape: cube, center: [0, 0, {z}], size: [{side}, {side}, {thickness}], material: body}}]
lights: [{{type: directional, direction: [0, {sine}, -{cosine}], irradiance: [1, 1, 1]}}]
settings: {{bounces: 0}}
"""


def camera(name, cosine, side, thickness):
    """Looks at the middle of one side of the plate; the lit one is at z = 0."""
    z = 0 if side > 0 else -thickness
    x = FAR * (1 - cosine ** 2) ** 0.5
    return (f'"{name}": {{type: perspective, position: [{x}, 0, {z + side * FAR * cosine}], '
            f"look_at: [0, 0, {z}], fov_deg: 0.4, resolution: [8, 8]}}")


def rendered(thickness, albedo, eta, model, incidence, folder):
    cameras = ", ".join(camera(name, *view, thickness) for name, view in VIEWS.items())
    scene, cache, image = folder / "slab.yaml", folder / "slab.tallow", folder / "slab.exr"
    scene.write_text(SCENE.format(cameras=cameras, s=albedo, a=max(1 - albedo, 1e-9), eta=eta,
                                  model=model, z=-thickness / 2, side=SIDE, thickness=thickness,
                                  sine=math.sin(incidence), cosine=math.cos(incidence)))
    programs.run("tallow-precompute", scene, "-o", cache)
    result = {}
    for name in VIEWS:
        programs.run("tallow-render", scene, "--cache", cache, "--camera", name, "-o", image,
                     "--aovs", "all", "--tolerance", "0.003", "--samples", "4",
                     "--set", "settings.tolerance=0.01")
        result[name] = float(read_image(image)["multiple"].mean())
    return result


def transmittance(eta, incidence):
    """Fresnel, unpolarized, from outside."""
    cos_i = math.cos(incidence)
    cos_t = math.sqrt(1 - (math.sin(incidence) / eta) ** 2)
    s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    return 1 - (s * s + p * p) / 2


def transported(thickness, albedo, eta, incidence):
    slab = Slab(thickness, albedo, eta)
    entering = transmittance(eta, incidence) * math.cos(incidence)
    inside = math.sqrt(1 - (math.sin(incidence) / eta) ** 2)
    sides = slab.leaving(slab.later_collisions(inside), [cosine for cosine, _ in VIEWS.values()])
    return {name: entering * sides[0 if side > 0 else 1][i]
            for i, (name, (_, side)) in enumerate(VIEWS.items())}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--eta", type=float, default=1.4)
    parser.add_argument("--albedo", type=float, nargs="+", default=[0.999, 0.95, 0.8])
    parser.add_argument("--thickness", type=float, nargs="+", default=[1, 2, 4, 8])
    parser.add_argument("--model", nargs="+", default=["body-aware", "transport"])
    parser.add_argument("--incidence", type=float, default=0, help="degrees")
    arguments = parser.parse_args()
    incidence = math.radians(arguments.incidence)
    print(f"| albedo | mean free paths | model | {' | '.join(VIEWS)} |")
    print("|---|---|---|" + "---|" * len(VIEWS))
    with tempfile.TemporaryDirectory() as folder:
        for albedo in arguments.albedo:
            for thickness in arguments.thickness:
                truth = transported(thickness, albedo, arguments.eta, incidence)
                for model in arguments.model:
                    ours = rendered(thickness, albedo, arguments.eta, model, incidence,
                                    pathlib.Path(folder))
                    errors = [100 * (ours[name] / truth[name] - 1) for name in VIEWS]
                    print(f"| {albedo:g} | {thickness:g} | {model} | "
                          f"{' | '.join(f'{x:+.0f} %' for x in errors)} |", flush=True)


if __name__ == "__main__":
    main()
