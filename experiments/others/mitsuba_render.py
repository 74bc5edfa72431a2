#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders a tallow case with Mitsuba 3, as a homogeneous medium behind a smooth boundary.

    experiments/others/mitsuba_render.py sphere dim -o out.exr --seconds 60

Needs `pip install mitsuba trimesh` (3.9.1) and Debian's libllvm19 for the llvm variants, which are
twice as fast here as the scalar one. LLVM 15 aborts while it compiles this integrator.

The integrator is `volpathmis` without depth limit or Russian roulette, in three grey renders, one a
channel: its `volpath` and its default roulette are biased on coloured or bright media. Every path
goes on until it leaves the body and must then meet the lamp by chance: light that crosses a smooth
boundary cannot be sampled. So the picture has no bias, and much noise.
"""
import os
import pathlib
import re
import sys
import tempfile
import time

import numpy as np

if not __package__:  # run as a program: the folder above holds the package
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
    __package__ = "others"
from . import passes, scene

VARIANTS = ("llvm_ad_mono", "llvm_ad_rgb", "scalar_rgb")
OLDEST_LLVM = 17     # the first that knows `fminimum` on x86; 15 aborts, 19 was tried
UNLIMITED = 1 << 30  # a depth that no path reaches


def find_llvm():
    """The newest LLVM library of the system that will do, or None."""
    found = {}
    for path in pathlib.Path("/usr/lib").glob("*/libLLVM*.so*"):
        if version := re.search(r"\d+", path.name):
            found[int(version[0])] = path
    newest = max(found, default=0)
    return found[newest] if newest >= OLDEST_LLVM else None


def default_variant():
    return VARIANTS[0] if "DRJIT_LIBLLVM_PATH" in os.environ or find_llvm() else "scalar_rgb"


def load_mitsuba(variant):
    """The module, set to a variant. Raises InputError with what to install."""
    if variant.startswith("llvm") and "DRJIT_LIBLLVM_PATH" not in os.environ:
        library = find_llvm()
        if not library:
            raise scene.InputError(f"--variant: {variant} needs Debian's libllvm19")
        os.environ["DRJIT_LIBLLVM_PATH"] = str(library)
    try:
        import mitsuba
        mitsuba.set_variant(variant)
    except ImportError as error:
        raise scene.InputError(f"mitsuba cannot be used: {error}; needs `pip install mitsuba`") \
            from None
    return mitsuba


def _grey(value):
    return {"type": "uniform", "value": float(value)}


def _shape(shape, folder):
    if isinstance(shape, scene.Sphere):
        return {"type": "sphere", "center": list(shape.center), "radius": shape.radius}
    import trimesh
    path = pathlib.Path(folder) / "body.ply"
    trimesh.Trimesh(shape.vertices, shape.faces, process=False).export(path)
    return {"type": "ply", "filename": str(path), "face_normals": True}


def _medium(medium, channel):
    phase = {"type": "hg", "g": medium.g} if medium.g else {"type": "isotropic"}
    return {"type": "homogeneous", "albedo": _grey(medium.albedo[channel]),
            "sigma_t": _grey(medium.sigma_t[channel]), "phase": phase}


def _body(case, channel, folder):
    body = _shape(case.shape, folder)
    material = case.material
    if isinstance(material, scene.Diffuse):
        body["bsdf"] = {"type": "diffuse", "reflectance": _grey(material.reflectance[channel])}
    else:
        body["bsdf"] = {"type": "dielectric", "int_ior": material.eta, "ext_ior": 1.0}
        body["interior"] = _medium(material, channel)
    return body


def _light(mi, light, channel):
    emission = _grey(light.radiance[channel])
    if isinstance(light, scene.Environment):
        return {"type": "constant", "radiance": emission}
    # Mitsuba's rectangle spans [-1, 1]^2 and shines along +z; u x v points away from the body.
    columns = np.eye(4)
    columns[:3, 0], columns[:3, 1] = -light.u / 2, light.v / 2
    columns[:3, 2], columns[:3, 3] = light.normal, light.center
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f(columns),
            "emitter": {"type": "area", "radiance": emission}}


def _sensor(mi, camera):
    to_world = mi.ScalarTransform4f().look_at(list(camera.position), list(camera.look_at),
                                              list(camera.up))
    return {"type": "perspective", "fov": float(np.degrees(camera.fov)), "fov_axis": "y",
            "to_world": to_world, "sampler": {"type": "independent"},
            "film": {"type": "hdrfilm", "width": camera.width, "height": camera.height,
                     "pixel_format": "luminance", "rfilter": {"type": "box"}}}


def _integrator(case, max_depth):
    if isinstance(case.material, scene.Diffuse):
        return {"type": "path", "max_depth": max_depth, "rr_depth": UNLIMITED}
    return {"type": "volpathmis", "max_depth": max_depth, "rr_depth": UNLIMITED}


class Mitsuba:
    """Renders a case. `max_depth` 2 is light scattered once, 1 is what shines by itself."""

    def __init__(self, case, variant=None, max_depth=-1):
        start = time.perf_counter()
        variant = variant or default_variant()
        self._mi = load_mitsuba(variant)
        with tempfile.TemporaryDirectory() as folder:
            self._scenes = [self._load(case, channel, max_depth, folder) for channel in range(3)]
        self.render(0, 1)  # compiles the kernels
        self.startup_seconds = time.perf_counter() - start

    def _load(self, case, channel, max_depth, folder):
        description = {"type": "scene", "integrator": _integrator(case, max_depth),
                       "sensor": _sensor(self._mi, case.camera),
                       "body": _body(case, channel, folder)}
        for index, light in enumerate(case.lights):
            description[f"light{index}"] = _light(self._mi, light, channel)
        return self._mi.load_dict(description)

    def render(self, seed, spp):
        """Radiance, (height, width, 3); equal seeds give equal pictures."""
        images = [np.array(self._mi.render(one, spp=spp, seed=3 * seed + channel), np.float64)
                  for channel, one in enumerate(self._scenes)]
        return np.concatenate([image.reshape(*image.shape[:2], 1) for image in images], axis=2)


def main():
    parser = passes.render_parser(__doc__.splitlines()[0])
    parser.add_argument("--variant", choices=VARIANTS, default=default_variant())
    arguments = parser.parse_args()
    case = scene.load_case(arguments.case, scene.find_material(arguments.medium))
    renderer = Mitsuba(case, arguments.variant)
    estimate = passes.accumulate(renderer, case.camera, arguments.spp, arguments.seconds)
    passes.write_estimate(arguments.output, estimate, renderer="mitsuba", scene=case.file,
                          medium=arguments.medium, variant=arguments.variant)


if __name__ == "__main__":
    sys.exit(passes.run(main))
