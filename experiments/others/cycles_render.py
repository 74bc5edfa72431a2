#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders a tallow case with Blender's Cycles, subsurface scattering by random walk or Burley.

    experiments/others/cycles_render.py sphere dim -o out.exr --seconds 60 --method random_walk

Needs `pip install bpy` (5.0.1, Python 3.11; optional: exits with 2 where it is missing). CPU, no
denoiser, box filter, no clamping, radiance of Cycles' linear Rec. 709 as it is.

The Principled BSDF takes a colour and a radius, not coefficients. They are given such that Cycles
walks through the medium itself:

* Radius. Both methods divide the given radius by 4 pi and take the result for the mean free path
  (of Burley's profile, for its `l`). So it gets 4 pi / (sigma_a + sigma_s'), with a scale of 1.
* Colour. The random walk inverts it to the single-scattering albedo of a half-space with matched
  index by van de Hulst's formula, with s = sqrt(1 - alpha'), alpha' = sigma_s' / (sigma_a +
  sigma_s'):

      A = (1 - s) (1 - 0.139 s) / (1 + 1.17 s)

  So it gets that A. Burley's profile takes the same A for the albedo of the surface.
* Anisotropy 0, with reduced coefficients. Index of refraction the medium's, roughness 0.

What Cycles leaves out stays left out: light is not refracted on entry and exit nor reflected back
inside, the random walk ends after 256 steps, and Burley's profile knows no shape.

Sources: Blender manual, Principled BSDF; van de Hulst, Multiple Light Scattering, 1980; Kulla,
Conty, Physically Based Shader Design in Arnold, SIGGRAPH course 2017; Christensen, Burley 2015.
"""
import contextlib
import os
import pathlib
import sys
import tempfile
import time

import numpy as np

if not __package__:  # run as a program: the folder above holds the package
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
    __package__ = "others"
from . import passes, scene

METHODS = ("random_walk", "burley")
BOUNCES = 64     # chosen: between parts of the body; the 10th changes no picture here any more
MOST_SAMPLES = 1 << 24  # a pixel, all passes; Cycles' own limit
SPHERE_CUTS = 7  # of an icosahedron: 0.003 % of the radius between facets and sphere


def is_available():
    """Whether Cycles can be used."""
    try:
        import bpy  # noqa: F401
        return True
    except ImportError:
        return False


def multiple_scattering_colour(medium):
    """Albedo of a half-space of the medium with matched index, a channel (van de Hulst 1980)."""
    s = np.sqrt(medium.sigma_a / (medium.sigma_a + medium.sigma_s_prime))
    return (1 - s) * (1 - 0.139 * s) / (1 + 1.17 * s)


def radius(medium):
    """What Cycles calls the radius of a medium, mm a channel."""
    return 4 * np.pi / (medium.sigma_a + medium.sigma_s_prime)


@contextlib.contextmanager
def silent():
    """Keeps stdout of compiled code quiet: Blender reports each frame there."""
    sys.stdout.flush()
    kept, null = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
        os.close(null)


def _placed(bpy, name, data, columns, position):
    """Adds an object whose x, y and z axes are `columns`."""
    import mathutils
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.transpose(columns), position
    placed = bpy.data.objects.new(name, data)
    placed.matrix_world = mathutils.Matrix(matrix.tolist())
    bpy.context.scene.collection.objects.link(placed)
    return placed


def _add_camera(bpy, camera):
    right, up, forward = camera.axes()
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "VERTICAL", camera.fov
    data.clip_start, data.clip_end = 0.01, 1e5
    bpy.context.scene.camera = _placed(bpy, "camera", data, [right, up, -forward], camera.position)


def _add_quad(bpy, light):
    width, height = np.linalg.norm(light.u), np.linalg.norm(light.v)
    data = bpy.data.lights.new("lamp", "AREA")
    data.shape, data.size, data.size_y = "RECTANGLE", width, height
    # Blender asks for the power: pi times area times radiance, in one colour and one strength.
    data.energy = float(np.pi * width * height * light.radiance.max())
    data.color = (light.radiance / light.radiance.max()).tolist()
    # It shines along its -z.
    _placed(bpy, "lamp", data, [-light.u / width, light.v / height, -light.normal], light.center)


def _set_environment(bpy, lights):
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    background = world.node_tree.nodes["Background"]
    shining = [light.radiance for light in lights if isinstance(light, scene.Environment)]
    background.inputs["Color"].default_value = [*(shining[0] if shining else (0, 0, 0)), 1]
    background.inputs["Strength"].default_value = 1


def _body_mesh(bpy, shape):
    data = bpy.data.meshes.new("body")
    if isinstance(shape, scene.Sphere):
        import bmesh
        mesh = bmesh.new()
        bmesh.ops.create_icosphere(mesh, subdivisions=SPHERE_CUTS, radius=shape.radius)
        mesh.to_mesh(data)
        mesh.free()
        data.shade_smooth()
        return data, shape.center
    data.from_pydata(shape.vertices.tolist(), [], shape.faces.tolist())
    data.shade_flat()
    return data, np.zeros(3)


def _material(bpy, material, method):
    made = bpy.data.materials.new("body")
    nodes, links = made.node_tree.nodes, made.node_tree.links
    if isinstance(material, scene.Diffuse):
        surface = nodes.new("ShaderNodeBsdfDiffuse")
        surface.inputs["Color"].default_value = [*material.reflectance, 1]
    else:
        surface = nodes["Principled BSDF"]
        surface.subsurface_method = method.upper()
        values = {"Base Color": [*multiple_scattering_colour(material), 1], "Roughness": 0,
                  "IOR": material.eta, "Subsurface Weight": 1, "Subsurface Scale": 1,
                  "Subsurface Radius": radius(material).tolist()}
        for name, value in values.items():
            surface.inputs[name].default_value = value
    links.new(surface.outputs["BSDF"], nodes["Material Output"].inputs["Surface"])
    return made


def _set_up_render(bpy, camera, bounces, file):
    render, cycles = bpy.context.scene.render, bpy.context.scene.cycles
    render.engine, cycles.device = "CYCLES", "CPU"
    render.resolution_x, render.resolution_y = camera.width, camera.height
    render.resolution_percentage = 100
    render.film_transparent = True  # alpha is coverage
    render.use_persistent_data = True
    render.use_compositing = render.use_sequencer = False
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.filepath = file
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.pixel_filter_type = "BOX"
    cycles.use_sample_subset, cycles.samples = True, MOST_SAMPLES
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = cycles.light_sampling_threshold = 0
    for kind in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", bounces)


class Cycles:
    """Renders a case. `bounces` 0 is light that was scattered once (diffuse cases)."""

    def __init__(self, case, method=METHODS[0], bounces=BOUNCES):
        start = time.perf_counter()
        import bpy
        self._bpy = bpy
        self._folder = tempfile.TemporaryDirectory()
        with silent():
            bpy.ops.wm.read_factory_settings(use_empty=True)
            self._build(case, method, bounces)
        self.render(0, 1)  # builds the acceleration structure
        self.startup_seconds = time.perf_counter() - start

    def _build(self, case, method, bounces):
        bpy = self._bpy
        _add_camera(bpy, case.camera)
        data, center = _body_mesh(bpy, case.shape)
        data.materials.append(_material(bpy, case.material, method))
        _placed(bpy, "body", data, np.eye(3), center)
        for light in case.lights:
            if isinstance(light, scene.Quad):
                _add_quad(bpy, light)
        _set_environment(bpy, case.lights)
        _set_up_render(bpy, case.camera, bounces, os.path.join(self._folder.name, "pass.exr"))

    def channels(self, seed, spp):
        """All channels by name, A (coverage) among them; `seed` counts passes of equal `spp`."""
        settings = self._bpy.context.scene
        # Pictures of few samples with other seeds share their errors (tried: 128 of 8 samples had
        # 19 % where 1024 at once have 3 %). Parts of one sequence do not: their mean is the picture
        # of all, and their spread overestimates its variance a little.
        settings.cycles.sample_offset, settings.cycles.sample_subset_length = seed * spp, spp
        settings.update_tag()  # or the kept picture of the last pass comes back
        with silent():
            self._bpy.ops.render.render(write_still=True)
        return passes.read_exr(settings.render.filepath)

    def render(self, seed, spp):
        """Radiance, (height, width, 3)."""
        return passes.layer(self.channels(seed, spp))


def main():
    parser = passes.render_parser(__doc__.splitlines()[0])
    parser.add_argument("--method", choices=METHODS, default=METHODS[0])
    arguments = parser.parse_args()
    if not is_available():
        print("cycles_render: needs Blender as a module: pip install bpy (Python 3.11)",
              file=sys.stderr)
        return 2
    case = scene.load_case(arguments.case, scene.find_material(arguments.medium))
    renderer = Cycles(case, arguments.method)
    estimate = passes.accumulate(renderer, case.camera, arguments.spp, arguments.seconds)
    passes.write_estimate(arguments.output, estimate, renderer=f"cycles {arguments.method}",
                          scene=case.file, medium=arguments.medium)


if __name__ == "__main__":
    sys.exit(passes.run(main))
