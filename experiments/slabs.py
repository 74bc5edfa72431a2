#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The body-aware model in plates, against transport.

    experiments/python experiments/slabs.py [--eta ETA] [--albedo A ...] [--thickness T ...]
                                            [--incidence DEGREES | --everywhere]

Plates of T mean free paths (1 mm), lit at right angles or DEGREES from that; prints how far off is
what leaves after two scatterings or more: on the lit side and on the other, seen at right angles and
at 45 degrees, in per cent of transport (slab_transport.py). With --everywhere light 1 comes from
everywhere; prints what of it a camera sees mirrored, passed, scattered once and more often, ours and
(in brackets) transport's.
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
from slab_transport import Slab, reflectance_inside  # noqa: E402

FAR = 300      # of the camera, mm
SIDE = 40      # of the plate, mm
COS_45 = 0.5 ** 0.5
VIEWS = {"lit": (1, 1), "lit 45": (COS_45, 1), "other": (1, -1), "other 45": (COS_45, -1)}

SCENE = """unit: mm
cameras: {{{cameras}}}
materials:
  body: {{type: subsurface, sigma_s_prime: [{s}, {s}, {s}], sigma_a: [{a}, {a}, {a}], eta: {eta}, model: {model}}}
objects: [{{shape: cube, center: [0, 0, {z}], size: [{side}, {side}, {thickness}], material: body}}]
lights: [{{{light}}}]
settings: {{bounces: 0}}
"""


def camera(name, cosine, side, thickness):
    """Looks at the middle of one side of the plate; the lit one is at z = 0."""
    z = 0 if side > 0 else -thickness
    x = FAR * (1 - cosine ** 2) ** 0.5
    return (f'"{name}": {{type: perspective, position: [{x}, 0, {z + side * FAR * cosine}], '
            f"look_at: [0, 0, {z}], fov_deg: 0.4, resolution: [8, 8]}}")


def beam(incidence):
    return (f"type: directional, direction: [0, {math.sin(incidence)}, -{math.cos(incidence)}], "
            "irradiance: [1, 1, 1]")


def rendered(thickness, albedo, eta, model, light, folder):
    """Layers by view, means."""
    cameras = ", ".join(camera(name, *view, thickness) for name, view in VIEWS.items())
    scene, cache, image = folder / "slab.yaml", folder / "slab.tallow", folder / "slab.exr"
    scene.write_text(SCENE.format(cameras=cameras, s=albedo, a=max(1 - albedo, 1e-9), eta=eta,
                                  model=model, z=-thickness / 2, side=SIDE, thickness=thickness,
                                  light=light))
    programs.run("tallow-precompute", scene, "-o", cache)
    result = {}
    for name in VIEWS:
        programs.run("tallow-render", scene, "--cache", cache, "--camera", name, "-o", image,
                     "--aovs", "all", "--tolerance", "0.003", "--samples", "4",
                     "--set", "settings.tolerance=0.01")
        result[name] = {layer: float(values.mean())
                        for layer, values in read_image(image).layers.items()}
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


EVERYWHERE = "type: environment, radiance: [1, 1, 1]"
LAYERS = ("specular", "transmitted", "single", "multiple")


def transported_everywhere(thickness, albedo, eta, view):
    """What a camera sees of light 1 from everywhere, by LAYERS."""
    slab, directions = Slab(thickness, albedo, eta), 64
    inside = math.sqrt(1 - (1 - view ** 2) / eta ** 2)
    mirror = float(reflectance_inside(numpy.array([inside]), eta)[0])
    through = math.exp(-thickness / inside)
    passed = (1 - mirror) ** 2 * through / (1 - (mirror * through) ** 2)
    once = more = 0.0
    for k in range(directions):  # of the midpoint rule
        mu = (k + 0.5) / directions
        refracted = math.sqrt(1 - (1 - mu ** 2) / eta ** 2)
        entering = 2 * math.pi * mu / directions * transmittance(eta, math.acos(mu))
        once += entering * sum(slab.leaving(slab.first_collisions(refracted), [view]))[0]
        more += entering * sum(slab.leaving(slab.later_collisions(refracted), [view]))[0]
    return dict(zip(LAYERS, (mirror + passed * mirror * through, passed, once, more)))


def print_everywhere(arguments, folder):
    print(f"| albedo | mean free paths | model | view | {' | '.join(LAYERS)} | all |")
    print("|---|---|---|---|" + "---|" * (len(LAYERS) + 1))
    for albedo in arguments.albedo:
        for thickness in arguments.thickness:
            for model in arguments.model:
                layers = rendered(thickness, albedo, arguments.eta, model, EVERYWHERE, folder)
                for name in ("lit", "lit 45"):
                    truth = transported_everywhere(thickness, albedo, arguments.eta, VIEWS[name][0])
                    ours = {layer: layers[name][layer] for layer in LAYERS}
                    pairs = [(ours[layer], truth[layer]) for layer in LAYERS]
                    pairs.append((sum(ours.values()), sum(truth.values())))
                    print(f"| {albedo:g} | {thickness:g} | {model} | {name} | "
                          f"{' | '.join(f'{a:.3f} ({b:.3f})' for a, b in pairs)} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--eta", type=float, default=1.4)
    parser.add_argument("--albedo", type=float, nargs="+", default=[0.999, 0.95, 0.8])
    parser.add_argument("--thickness", type=float, nargs="+", default=[1, 2, 4, 8])
    parser.add_argument("--model", nargs="+", default=["body-aware", "transport"])
    light = parser.add_mutually_exclusive_group()
    light.add_argument("--incidence", type=float, default=0, help="degrees")
    light.add_argument("--everywhere", action="store_true")
    arguments = parser.parse_args()
    if arguments.everywhere:
        with tempfile.TemporaryDirectory() as folder:
            print_everywhere(arguments, pathlib.Path(folder))
        return
    incidence = math.radians(arguments.incidence)
    print(f"| albedo | mean free paths | model | {' | '.join(VIEWS)} |")
    print("|---|---|---|" + "---|" * len(VIEWS))
    with tempfile.TemporaryDirectory() as folder:
        for albedo in arguments.albedo:
            for thickness in arguments.thickness:
                truth = transported(thickness, albedo, arguments.eta, incidence)
                for model in arguments.model:
                    ours = rendered(thickness, albedo, arguments.eta, model, beam(incidence),
                                    pathlib.Path(folder))
                    errors = [100 * (ours[name]["multiple"] / truth[name] - 1) for name in VIEWS]
                    print(f"| {albedo:g} | {thickness:g} | {model} | "
                          f"{' | '.join(f'{x:+.0f} %' for x in errors)} |", flush=True)


if __name__ == "__main__":
    main()
