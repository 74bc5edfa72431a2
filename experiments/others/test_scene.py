# SPDX-License-Identifier: Apache-2.0
"""Tests of scene.py: camera, transforms, lights and media. Renders nothing.

    python -m unittest discover experiments/others -t experiments
"""
import math
import pathlib
import tempfile
import unittest

import numpy as np

from others import scene

SPHERE = """\
unit: cm
cameras:
  main: {type: perspective, position: [0, 0, 6], look_at: [0, 0, 0], fov_deg: 60,
         resolution: [8, 4]}
materials:
  body: {type: subsurface, sigma_s: [2, 4, 8], sigma_a: 1e-3, g: 0.5, eta: 1.4}
objects:
  - {shape: sphere, center: [1, 0, 0], radius: 2, material: body}
lights:
  - {type: quad, position: [0, 3, 0], look_at: [0, 0, 0], size: [1, 2], radiance: 5}
"""


def write(text):
    folder = pathlib.Path(tempfile.mkdtemp(dir=_folder.name))
    (folder / "case.yaml").write_text(text)
    return folder / "case.yaml"


def setUpModule():
    global _folder
    _folder = tempfile.TemporaryDirectory()


def tearDownModule():
    _folder.cleanup()


class Cameras(unittest.TestCase):
    def setUp(self):
        self.camera = scene.load_case(write(SPHERE)).camera

    def test_axes_are_right_handed_seen_from_behind(self):
        np.testing.assert_allclose(self.camera.axes(), [[1, 0, 0], [0, 1, 0], [0, 0, -1]],
                                   atol=1e-15)

    def test_the_field_of_view_is_vertical(self):
        top = self.camera.direction(4, 0)
        self.assertAlmostEqual(math.degrees(math.asin(top[1])), 30)
        corner = self.camera.direction(8, 0)
        self.assertAlmostEqual(corner[0] / corner[1], 2)  # square pixels, right of the image at +x

    def test_lengths_are_mm(self):
        np.testing.assert_allclose(self.camera.position, [0, 0, 60])


class Transforms(unittest.TestCase):
    def steps(self, text):
        return scene.parse_yaml("steps: " + text, "t")["steps"]

    def test_steps_run_in_their_order(self):
        linear, translation = scene.read_transform(
            self.steps("[{translate: [1, 0, 0]}, {scale: 2}, {rotate_deg: [0, 0, 3, 90]}]"), 10)
        # (1, 0, 0) -> (11, 0, 0) -> (22, 0, 0) -> (0, 22, 0)
        np.testing.assert_allclose(linear @ [1, 0, 0] + translation, [0, 22, 0], atol=1e-12)

    def test_a_rotation_is_right_handed(self):
        np.testing.assert_allclose(scene.rotation([0, 1, 0], 90) @ [0, 0, 1], [1, 0, 0], atol=1e-15)
        np.testing.assert_allclose(scene.rotation([1, 1, 1], 120) @ [1, 0, 0], [0, 1, 0],
                                   atol=1e-15)

    def test_a_scale_may_differ_by_axis(self):
        linear, _ = scene.read_transform(self.steps("[{scale: [1, 2, 3]}]"), 1)
        np.testing.assert_allclose(linear, np.diag([1, 2, 3]))


class Meshes(unittest.TestCase):
    def tetrahedron(self, faces):
        text = SPHERE.replace("{shape: sphere, center: [1, 0, 0], radius: 2, material: body}",
                              "{shape: mesh, file: t.off, material: body, normals: flat, "
                              "transform: [{scale: 2}, {translate: [0, 1, 0]}]}")
        case = write(text)
        rows = ["OFF", "4 4 0", "0 0 0", "1 0 0", "0 1 0", "0 0 1", *faces]
        (case.parent / "t.off").write_text("\n".join(rows) + "\n")
        return scene.load_case(case).shape

    def test_vertices_are_scaled_to_mm_and_placed(self):
        mesh = self.tetrahedron(["3 0 2 1", "3 0 1 3", "3 0 3 2", "3 1 2 3"])
        np.testing.assert_allclose(mesh.vertices.max(axis=0), [20, 30, 20])
        self.assertAlmostEqual(scene.signed_volume(mesh.vertices, mesh.faces), 20**3 / 6)

    def test_an_inverted_mesh_is_turned_outward(self):
        mesh = self.tetrahedron(["3 0 1 2", "3 0 3 1", "3 0 2 3", "3 1 3 2"])
        self.assertGreater(scene.signed_volume(mesh.vertices, mesh.faces), 0)


class Lights(unittest.TestCase):
    def test_a_quad_straight_above_has_north_as_its_top(self):
        quad, = scene.load_case(write(SPHERE)).lights
        np.testing.assert_allclose(quad.normal, [0, -1, 0])
        np.testing.assert_allclose(quad.v, [0, 0, -20], atol=1e-12)
        np.testing.assert_allclose(np.cross(quad.u, quad.v), -200 * quad.normal, atol=1e-9)

    def test_standard_lamps_look_at_the_body(self):
        for name in ("sphere", "leaf"):
            case = scene.load_case(name)
            quad, = case.lights
            self.assertAlmostEqual(np.linalg.norm(quad.u), 36)
            self.assertLess(np.dot(quad.normal, quad.center - case.camera.look_at), 0)


class Media(unittest.TestCase):
    def test_coefficients(self):
        medium = scene.load_case(write(SPHERE)).material
        np.testing.assert_allclose(medium.sigma_a, 1e-3)  # 1/mm whatever `unit` says
        np.testing.assert_allclose(medium.sigma_s_prime, [1, 2, 4])

    def test_a_forward_preset_keeps_its_reduced_scattering(self):
        straight = scene.find_material("{type: subsurface, preset: marble}")
        forward = scene.find_material("{type: subsurface, preset: marble, g: 0.9}")
        np.testing.assert_allclose(forward.sigma_s, 10 * straight.sigma_s)
        np.testing.assert_allclose(straight.sigma_s, [2.19, 2.62, 3.00])

    def test_the_media_of_the_standard_cases(self):
        for name in ("marble", "skimmilk", "skin1", "dim"):
            self.assertTrue(np.all(scene.find_material(name).albedo < 1))


class Errors(unittest.TestCase):
    def expect(self, text, message):
        with self.assertRaisesRegex(scene.InputError, message):
            scene.load_case(write(text))

    def test_places_are_named(self):
        self.expect(SPHERE.replace("radius: 2", "radius: x"),
                    r"case.yaml:8:\d+: radius: expected a number, got 'x'")
        self.expect(SPHERE.replace("radius: 2", "radus: 2"),
                    r"case.yaml:8:\d+: radus: expected one")
        self.expect(SPHERE.replace("fov_deg: 60,", ""), r"case.yaml:3:\d+: missing key 'fov_deg'")
        self.expect(SPHERE.replace("unit: cm", "unit: cm\nunit: mm"),
                    "case.yaml:2:1: unit: .* once")
        self.expect(SPHERE.replace("]", "}", 1), r"case.yaml:3:\d+: ")

    def test_what_the_standard_cases_do_not_use_is_refused(self):
        self.expect(SPHERE.replace("type: quad", "type: spot"), "expected one of environment, quad")


if __name__ == "__main__":
    unittest.main()
