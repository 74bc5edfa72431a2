# SPDX-License-Identifier: Apache-2.0
"""experiments/compare.py on images whose errors are known, and on ones that cannot be compared."""
import json
import math
import pathlib
import tempfile
import unittest

import numpy
from PIL import Image

from images import flat, run, run_process, write_exr  # puts experiments/ on the path
from harness import metrics  # noqa: E402


class Compare(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)

    def write(self, name, layers, coverage=None):
        return write_exr(self.path / name, layers, coverage)

    def rows(self, *arguments):
        """Rows of the JSON by layer and channel."""
        code, out, err = run("compare.py", *arguments, "--json")
        self.assertEqual(code, 0, err)
        return {(row["layer"], row["channel"]): row for row in json.loads(out)["rows"]}

    def assert_fails(self, expected, *arguments):
        code, out, err = run("compare.py", *arguments)
        self.assertEqual((code, out), (3, ""), err)
        self.assertEqual(err, f"compare.py: error: {expected}\n")

    def test_equal_images_have_no_error(self):
        pixels = flat([0.2, 0.5, 1.5])
        row = self.rows(self.write("a.exr", {"": pixels}), self.write("b.exr", {"": pixels}))
        for name in ("relRMSE", "bias", "p99", "max", "flip"):
            self.assertEqual(row["RGB", "all"][name], 0, name)

    def test_known_errors_by_layer_and_channel(self):
        a = self.write("a.exr", {"": flat([1.1, 1, 1]), "single": flat(2)})
        b = self.write("b.exr", {"": flat(1), "single": flat(4)})
        rows = self.rows(a, b)
        whole, red, green = (rows["RGB", channel] for channel in ("all", "R", "G"))
        self.assertAlmostEqual(whole["relRMSE"], 0.1 / math.sqrt(3), 6)
        self.assertAlmostEqual(whole["bias"], 0.1 / 3, 6)
        self.assertAlmostEqual(whole["max"], 0.1, 6)
        self.assertAlmostEqual(red["relRMSE"], 0.1, 6)
        self.assertEqual(green["relRMSE"], 0)
        self.assertAlmostEqual(rows["single", "all"]["bias"], -0.5)

    def test_relative_errors_of_dark_pixels_are_bounded(self):
        reference, image = flat(1), flat(1)
        reference[0, 0], image[0, 0] = 0, 0.1
        mean = reference.mean()
        row = self.rows(self.write("a.exr", {"": image}), self.write("b.exr", {"": reference}))
        self.assertAlmostEqual(row["RGB", "all"]["max"], 0.1 / (0.01 * mean), 4)

    def test_noise_of_the_reference_is_taken_off(self):
        # A reference with noise of standard deviation 0.1 and an image 5 % too bright: without
        # the variance sqrt(0.1^2 + 0.05^2) is measured, with it 0.05. The standard error of the
        # mean square of 30000 numbers is 0.0125 * sqrt(2 / 30000) = 1e-4, of the root 1e-3 at 0.05.
        reference = numpy.random.default_rng(3).normal(1, 0.1, (100, 100, 3))
        a = self.write("a.exr", {"": flat(1.05, 100, 100)})
        b = self.write("b.exr", {"": reference, "variance": flat(0.01, 100, 100)})
        noisy = self.rows(a, b)["RGB", "all"]
        clean = self.rows(a, b, "--variance", "auto")["RGB", "all"]
        self.assertAlmostEqual(noisy["relRMSE"], math.hypot(0.1, 0.05), delta=0.005)
        self.assertAlmostEqual(clean["relRMSE"], 0.05, delta=0.005)
        self.assertAlmostEqual(clean["noise"], 0.1, delta=0.001)
        self.assertNotIn("noise", noisy)

    def test_variances_of_a_sum_of_layers_add_up(self):
        a = self.write("a.exr", {"multiple": flat(2)})
        layers = {"multi": flat(1), "ext": flat(1), "multi_variance": flat(0.03)}
        b = self.write("b.exr", {**layers, "ext_variance": flat(0.01)})
        half = self.write("half.exr", layers)
        options = "--layers", "multiple=multi+ext", "--variance", "auto"
        row = self.rows(a, b, *options)["multiple=multi+ext", "all"]
        self.assertAlmostEqual(row["noise"], 0.2 / 2, 6)
        self.assertNotIn("noise", self.rows(a, half, *options)["multiple=multi+ext", "all"])

    def test_noise_larger_than_the_error_leaves_zero(self):
        a = self.write("a.exr", {"": flat(1.05)})
        b = self.write("b.exr", {"": flat(1), "variance": flat(0.01)})
        self.assertEqual(self.rows(a, b, "--variance", "variance")["RGB", "all"]["relRMSE"], 0)

    def test_blocks_average_before_p99_and_max_alone(self):
        reference, image = flat(1), flat(1)
        image[::2] = 1.2
        image[1::2] = 0.8
        a, b = self.write("a.exr", {"": image}), self.write("b.exr", {"": reference})
        row = self.rows(a, b, "--block", "2")["RGB", "all"]
        self.assertAlmostEqual(row["relRMSE"], 0.2, 6)
        self.assertAlmostEqual(row["p99"], 0, 6)
        self.assertAlmostEqual(row["max"], 0, 6)

    def test_noise_alone_has_a_percentile(self):
        reference = flat(1)
        error = numpy.random.default_rng(1).normal(0, 0.1, (160, 200, 3)).astype(numpy.float32)
        flat_, mask = numpy.ones((160, 200, 3)), numpy.ones((160, 200), bool)
        variance = numpy.full_like(flat_, 0.01)
        for block in (1, 2):
            found = metrics.compare(flat_ + error, flat_, mask, variance, block)
            self.assertAlmostEqual(found["noise_p99"], 0.2576 / block, 4)
            self.assertAlmostEqual(found["p99"] / found["noise_p99"], 1, 1)
        self.assertEqual(metrics.compare(reference, reference, mask[:16, :20],
                                         0 * reference)["noise_p99"], 0)

    def test_masks(self):
        image, coverage = flat(1), numpy.zeros((16, 20))
        image[:8] = 3  # wrong only where nothing is seen
        coverage[8:] = 1
        a = self.write("a.exr", {"": image})
        b = self.write("b.exr", {"": flat(1), "depth": 5 * coverage}, coverage)
        bare = self.write("bare.exr", {"": flat(1)})
        self.assertEqual(self.rows(a, b)["RGB", "all"]["max"], 0)
        self.assertEqual(self.rows(a, b, "--mask", "depth")["RGB", "all"]["max"], 0)
        self.assertEqual(self.rows(a, b, "--mask", "depth>4")["RGB", "all"]["max"], 0)
        self.assertEqual(self.rows(a, b, "--mask", "A>-1")["RGB", "all"]["max"], 2)
        self.assertEqual(self.rows(a, bare)["RGB", "all"]["max"], 2)
        self.assert_fails("no pixel lies in the mask", a, b, "--mask", "depth>5")

    def test_sums_and_layers_of_other_name(self):
        a = self.write("a.exr", {"": flat(9), "multiple": flat(1), "single": flat(0.5)})
        b = self.write("b.exr", {"": flat(1)})
        row, = (r for (_, channel), r in self.rows(a, b, "--layers", "multiple+single=RGB").items()
                if channel == "all")
        self.assertAlmostEqual(row["bias"], 0.5)

    def test_flip_does_not_depend_on_the_background(self):
        rng = numpy.random.default_rng(5)
        body = rng.uniform(0.2, 0.8, (8, 8, 3))
        values = []
        for size in (16, 64):
            reference, coverage = numpy.zeros((size, size, 3)), numpy.zeros((size, size))
            reference[4:12, 4:12], coverage[4:12, 4:12] = body, 1
            a = self.write("a.exr", {"": 1.1 * reference + 5 * (1 - coverage[..., None])})
            b = self.write("b.exr", {"": reference}, coverage)
            values.append(self.rows(a, b)["RGB", "all"]["flip"])
        self.assertGreater(values[0], 0.01)
        self.assertAlmostEqual(values[0], values[1], 3)

    def test_flip_at_an_exposure_sees_no_difference_above_white(self):
        a, b = self.write("a.exr", {"": flat(8)}), self.write("b.exr", {"": flat(4)})
        self.assertEqual(self.rows(a, b, "--exposure", "0")["RGB", "all"]["flip"], 0)
        self.assertGreater(self.rows(a, b, "--exposure", "-4")["RGB", "all"]["flip"], 0.05)

    def test_pictures(self):
        image, coverage = flat(1), numpy.ones((16, 20))
        image[:, :10], image[:, 10:], coverage[0] = 1.5, 0.5, 0
        a, b = self.write("a.exr", {"": image}), self.write("b.exr", {"": flat(1)}, coverage)
        difference, flip = self.path / "d.png", self.path / "f.png"
        code, _, err = run("compare.py", a, b, "--difference", difference, "--flip-map", flip)
        self.assertEqual(code, 0, err)
        with Image.open(difference) as picture:
            pixels = numpy.asarray(picture.convert("RGB")).astype(int)
        self.assertGreater(pixels.shape[0], 2 * 16)  # the scale stands below
        self.assertEqual(pixels.shape[1], 2 * 20)
        brighter, darker, outside = pixels[20, 5], pixels[20, 35], pixels[0, 5]
        self.assertGreater(brighter[0], brighter[2] + 50)  # red
        self.assertGreater(darker[2], darker[0] + 50)      # blue
        self.assertEqual(len(set(outside)), 1)             # grey
        with Image.open(flip) as picture:
            self.assertEqual(picture.size[0], 2 * 20)

    def test_fail_above(self):
        a, b = self.write("a.exr", {"": flat(1.1)}), self.write("b.exr", {"": flat(1)})
        self.assertEqual(run("compare.py", a, b, "--fail-above", "0.11")[0], 0)
        code, out, err = run_process("compare.py", a, b, "--fail-above", "0.09")
        self.assertEqual(code, 1)
        self.assertIn("relRMSE", out)
        self.assertEqual(err, "compare.py: layer RGB: relRMSE 0.1 is above 0.09\n")

    def test_bad_input(self):
        a = self.write("a.exr", {"": flat(1), "single": flat(1)})
        small = self.write("small.exr", {"": flat(1, 8, 8)})
        self.assert_fails(f"the images differ in size: {a} has 20 x 16, {small} has 8 x 8",
                          a, small)
        self.assert_fails(f"{a}: no layer glow, expected one of RGB, single", a, a,
                          "--layers", "glow")
        self.assert_fails(f"{a}: no layer noise, expected one of RGB, single", a, a,
                          "--variance", "noise")
        self.assert_fails("--mask: expected a number after >, got 'x'", a, a, "--mask", "single>x")
        none, text, half = (self.path / name for name in ("none.exr", "text.exr", "half.exr"))
        self.assert_fails(f"{none}: No such file or directory", a, none)
        text.write_text("no image")
        self.assert_fails(f"{text}: not an EXR file", text, a)
        half.write_bytes(a.read_bytes()[:100])
        code, _, err = run_process("compare.py", half, a)
        self.assertEqual(code, 3)
        self.assertIn(f"compare.py: error: {half}: not a readable EXR file: ", err)

    def test_pixels_that_are_no_numbers(self):
        pixels = flat(1)
        pixels[3, 7, 1] = numpy.nan
        a, b = self.write("a.exr", {"": pixels}), self.write("b.exr", {"": flat(1)})
        self.assert_fails(f"{a}: layer RGB is not finite at pixel 7,3", a, b)

    def test_a_black_reference(self):
        a, b = self.write("a.exr", {"": flat(1)}), self.write("b.exr", {"": flat(0)})
        self.assert_fails("the reference's mean over the mask is 0, expected more than 0", a, b)

    def test_usage(self):
        a = self.write("a.exr", {"": flat(1)})
        self.assertEqual(run("compare.py", a)[0], 2)
        self.assertEqual(run("compare.py", a, a, "--block", "0")[0], 2)
        self.assertEqual(run("compare.py", a, a, "--nonsense")[0], 2)

    def test_a_picture_that_cannot_be_written(self):
        a, b = self.write("a.exr", {"": flat(1.1)}), self.write("b.exr", {"": flat(1)})
        file = self.path / "file"
        file.write_text("")
        self.assertEqual(run("compare.py", a, b, "--difference", file / "d.png")[0], 4)


if __name__ == "__main__":
    unittest.main()
