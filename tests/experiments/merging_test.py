# SPDX-License-Identifier: Apache-2.0
"""experiments/harness/merging.py on pictures whose averages are known."""
import pathlib
import tempfile
import unittest

import numpy
import OpenEXR

import images
from harness import merging
from harness.suite import InputError

METADATA = {"scene": "ball.yaml", "set": "", "camera": "main", "estimator": "combined",
            "paths": "300", "camera_rays": "30", "batches": "16", "seconds": "7", "seed": "1",
            "noise": "0.5"}


class Merging(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, mean, variance, coverage=1.0, **metadata):
        """A picture of one colour, scattered once, or of the arrays that are given."""
        shape = (12, 10)
        full = lambda value: numpy.broadcast_to(numpy.float32(value), shape).copy()
        channels = {"A": full(coverage)}
        for c in "RGB":
            channels[c] = channels[f"single.{c}"] = full(mean)
            channels[f"variance.{c}"] = channels[f"single_variance.{c}"] = full(variance)
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        header |= {f"tallow/{key}": value for key, value in (METADATA | metadata).items()}
        OpenEXR.File(header, channels).write(str(self.folder / name))
        return self.folder / name

    def assert_refused(self, expected, a, b):
        before = a.read_bytes()
        with self.assertRaises(InputError) as caught:
            merging.merge(a, b)
        self.assertIn(expected, str(caught.exception))
        self.assertEqual(a.read_bytes(), before)

    def test_equal_variances_give_the_mean_and_half_the_variance(self):
        a = self.write("a.exr", 1.0, 0.25)
        noise = merging.merge(a, self.write("b.exr", 3.0, 0.25, seed="2"))
        channels, _ = merging.read_channels(a)
        for name in ("R", "G", "B", "single.R", "single.B"):
            numpy.testing.assert_array_equal(channels[name], 2.0, name)
        for name in ("variance.R", "single_variance.B"):
            numpy.testing.assert_array_equal(channels[name], 0.125, name)
        self.assertAlmostEqual(noise, 0.125 ** 0.5 / 2, 12)

    def test_weights_go_with_the_inverse_of_the_variances(self):
        a = self.write("a.exr", 1.0, 0.75)
        merging.merge(a, self.write("b.exr", 2.0, 0.25, seed="2"))
        channels, _ = merging.read_channels(a)
        numpy.testing.assert_array_equal(channels["G"], 1.75)
        # 1 / (1 / 0.75 + 1 / 0.25) = 0.1875, the least that there is
        numpy.testing.assert_array_equal(channels["variance.G"], 0.1875)

    def test_one_bright_pixel_does_not_change_the_weight(self):
        variance = numpy.full((12, 10), 0.25)
        variance[3, 4] = 1000
        a = self.write("a.exr", 1.0, variance)
        merging.merge(a, self.write("b.exr", 3.0, 0.25, seed="2"))
        numpy.testing.assert_array_equal(merging.read_channels(a)[0]["R"], 2.0)

    def test_metadata_says_what_is_in_it(self):
        a = self.write("a.exr", 1.0, 0.25, seed="1 5")
        noise = merging.merge(a, self.write("b.exr", 1.0, 0.25, seed="2", paths="100", batches="8"))
        _, header = merging.read_channels(a)
        said = {key: header[f"tallow/{key}"] for key in METADATA}
        self.assertEqual(said, METADATA | {"seed": "1 5 2", "paths": "400", "batches": "24",
                                           "camera_rays": "60", "seconds": "14",
                                           "noise": f"{noise:.5f}"})

    def test_averages_of_independent_pictures_have_the_variance_that_they_say(self):
        random = numpy.random.default_rng(1)
        sigma = 0.1
        picture = lambda: 1 + sigma * random.standard_normal((12, 10))
        a = self.write("a.exr", picture(), sigma ** 2)
        for seed in range(2, 5):
            merging.merge(a, self.write("b.exr", picture(), sigma ** 2, seed=str(seed)))
        channels, _ = merging.read_channels(a)
        # Four pictures: 1/4 of the variance, within the 5 bits that are stored (1/64).
        numpy.testing.assert_allclose(channels["variance.R"], sigma ** 2 / 4, rtol=1 / 32)
        # Of 120 pixels; seeded: measured 0.88 of what is said; 0.13 is one standard deviation.
        self.assertAlmostEqual(numpy.var(channels["R"]) / (sigma ** 2 / 4), 1, delta=0.4)

    def test_other_pictures_are_refused(self):
        a = self.write("a.exr", 1.0, 0.25)
        self.assert_refused("seed 1 is in", a, self.write("b.exr", 1.0, 0.25))
        self.assert_refused("scene is not that of", a,
                            self.write("b.exr", 1.0, 0.25, seed="2", scene="cube.yaml"))
        self.assert_refused("channels and coverage", a,
                            self.write("b.exr", 1.0, 0.25, coverage=0.75, seed="2"))
        text = self.folder / "text.exr"
        text.write_text("no picture")
        self.assert_refused("not a readable EXR file", a, text)
        with self.assertRaises(InputError):
            merging.require_new_seed(a, 1)
        merging.require_new_seed(a, 2)


if __name__ == "__main__":
    unittest.main()
