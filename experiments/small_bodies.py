#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Models in balls and bars of few mean free paths, against volumetric truth.

    experiments/python experiments/small_bodies.py [--eta ETA] [--seconds S] [--model MODEL ...]

Bodies of albedo 0.998, 0.95 and 0.8 (red, green, blue) in front of a lamp, seen along its light, across
it and against it; sizes in mean free paths (1 mm). Prints how far off the light that scattered twice or
more is, summed over the picture, in per cent, with the reference's standard error. References of
tallow-reference take S seconds each (12) and are kept in build/small_bodies.
"""
import argparse
import math
import pathlib
import sys

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "experiments"))

from harness import programs  # noqa: E402
from harness.images import read_image  # noqa: E402

FOLDER = ROOT / "build" / "small_bodies"
FAR = 100  # of lamp and cameras, mm
VIEWS = {"along the light": (0, 0, 1), "across": (1, 0, 0), "against": (0.25, 0, -1)}
BODIES = [("ball", radius) for radius in (0.7, 1.4, 2.8, 5.6)]
BODIES += [("bar", radius) for radius in (0.7, 1.4, 2.8)]

SCENE = """unit: mm
cameras: {{{cameras}}}
materials:
  body: {{type: subsurface, sigma_s_prime: [0.998, 0.95, 0.8], sigma_a: [0.002, 0.05, 0.2], eta: {eta}}}
objects: [{{{shape}, center: [0, 0, 0], material: body}}]
lights: [{{type: quad, position: [0, 0, -{far}], look_at: [0, 0, 0], size: [20, 20], radiance: 100}}]
settings: {{bounces: 0}}
"""


def camera(name, direction, extent):
    position = [FAR * c for c in direction]
    fov = 2 * math.degrees(math.atan(extent / FAR))
    return (f'"{name}": {{type: perspective, position: {position}, look_at: [0, 0, 0], '
            f"fov_deg: {fov:.4f}, resolution: [32, 32]}}")


def write_scene(kind, radius, eta):
    """Bars are square, 20 mm long, and reach out of the picture."""
    extent = (1.15 if kind == "ball" else 1.6) * radius
    shape = (f"shape: sphere, radius: {radius}" if kind == "ball"
             else f"shape: cube, size: [{2 * radius}, 20, {2 * radius}]")
    cameras = ", ".join(camera(name, way, extent) for name, way in VIEWS.items())
    scene = FOLDER / f"{kind}-{radius}-{eta}.yaml"
    text = SCENE.format(cameras=cameras, eta=eta, shape=shape, far=FAR)
    if not scene.exists() or scene.read_text() != text:
        scene.write_text(text)
    return scene


def reference(scene, view, seconds):
    picture = scene.with_name(f"{scene.stem}-{view.split()[0]}.exr")
    if not picture.exists():
        programs.run("tallow-reference", scene, "--camera", view, "-o", picture, "--seconds", seconds)
    return read_image(picture)


def errors(ours, truth):
    """[channel] per cent, and their standard errors."""
    lit = truth["multi"].max(axis=-1) > 0
    sums = truth["multi"][lit].sum(axis=0)
    deviation = numpy.sqrt(truth["multi_variance"][lit].sum(axis=0))
    return 100 * (ours["multiple"][lit].sum(axis=0) / sums - 1), 100 * deviation / sums


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--eta", type=float, default=1.3)
    parser.add_argument("--seconds", type=int, default=12)
    parser.add_argument("--model", nargs="+", default=["body-aware", "transport"])
    arguments = parser.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    print(f"| body | mean free paths across | model | {' | '.join(VIEWS)} |")
    print("|---|---|---|" + "---|" * len(VIEWS))
    cache, image = FOLDER / "small.tallow", FOLDER / "small.exr"
    for kind, radius in BODIES:
        scene = write_scene(kind, radius, arguments.eta)
        programs.run("tallow-precompute", scene, "-o", cache)
        for model in arguments.model:
            cells = []
            for view in VIEWS:
                programs.run("tallow-render", scene, "--cache", cache, "--camera", view, "-o", image,
                             "--aovs", "all", "--samples", "4", "--set",
                             f"materials.body.model={model}")
                error, deviation = errors(read_image(image),
                                          reference(scene, view, arguments.seconds))
                cells.append(", ".join(f"{e:+.0f}" for e in error) + f" (± {deviation.max():.1f})")
            print(f"| {kind} | {2 * radius:g} | {model} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
