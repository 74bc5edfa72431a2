# SPDX-License-Identifier: Apache-2.0
"""The reader that docs/CACHE_FORMAT.md prints reads what tallow-precompute writes."""
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from images import ROOT
from harness import programs

# Light that comes straight down on two bodies, so that what enters each is known: without
# refraction (eta 1) all that falls on its shadow, irradiance * pi * radius^2.
SCENE = """\
cameras:
  main: {type: perspective, position: [0, 0, 60], look_at: [0, 0, 0], fov_deg: 30,
         resolution: [8, 8]}
materials:
  body: {type: subsurface, sigma_s_prime: 1, sigma_a: 0.1, eta: 1}
objects:
  - {shape: sphere, center: [-10, 0, 0], radius: 5, material: body}
  - {shape: sphere, center: [10, 0, 0], radius: 2, material: body}
lights:
  - {type: directional, direction: [0, -1, 0], irradiance: [1, 2, 3], group: noon}
"""


def snippet():
    """The only block of Python in the document, as it stands there."""
    text = (ROOT / "docs/CACHE_FORMAT.md").read_text(encoding="utf-8")
    block, = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return block


class Reader(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def read(self):
        """What the snippet prints of a fresh cache of SCENE."""
        scene, cache, reader = (self.folder / name for name in ("a.yaml", "a.tallow", "read.py"))
        scene.write_text(SCENE)
        reader.write_text(snippet())
        programs.run("tallow-precompute", scene, "-o", cache)
        done = subprocess.run([sys.executable, reader, cache], capture_output=True, text=True,
                              check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def test_bodies_and_the_light_that_enters_them(self):
        out = self.read()
        self.assertEqual(re.findall(r"^body (\d): \((\d), ", out, re.MULTILINE),
                         [("0", "0"), ("1", "1")])
        fluxes = re.findall(r"^  noon: flux \[\s*(\S+)\s+(\S+)\s+(\S+?)\s*\] W$", out,
                            re.MULTILINE)
        for flux, radius in zip(fluxes, (5, 2), strict=True):
            for got, irradiance in zip(map(float, flux), (1, 2, 3)):
                entered = irradiance * 3.14159 * radius ** 2
                self.assertAlmostEqual(got, entered, delta=0.02 * entered)


if __name__ == "__main__":
    unittest.main()
