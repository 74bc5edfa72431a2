# SPDX-License-Identifier: Apache-2.0
"""tallow-view in a window of a virtual display, with real keys and a real mouse.

    window_test.py TALLOW_VIEW FOLDER

Waits are for what the program's frame log says, never for a time.
"""

import csv
import ctypes
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time
import unittest

import numpy
import OpenEXR
import yaml
from PIL import Image

SCENE = """
cameras:
  main: {type: perspective, position: [3, 3, 7], look_at: [0, 0, 0], fov_deg: 30, resolution: [160, 120]}
materials:
  wax: {type: subsurface, sigma_s_prime: [1, 1.5, 2], sigma_a: [0.02, 0.1, 0.3], eta: 1.4}
  floor: {type: diffuse, reflectance: 0.4}
objects:
  - {shape: cube, size: [3, 2, 2], material: wax}
  - {shape: plane, point: [0, -1.5, 0], normal: [0, 1, 0], material: floor}
lights:
  - {type: quad, position: [0, 6, -3], look_at: [0, 0, 0], size: [2, 2], radiance: 9, group: key}
settings: {samples: 3, light_samples: 4, indirect_samples: 4}
"""
PATIENCE_S = 60  # chosen: what takes longer does not come


def wait_for(condition, what):
    """The first true value of condition(), asked again and again."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.01)
    raise AssertionError(f"waited in vain for {what}")


class Display:
    """A virtual X display of its own."""

    def __init__(self):
        # Without -noreset the server starts anew when xdotool, its only client for a moment,
        # leaves, and refuses the viewer meanwhile.
        read, write = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24", "-nolisten", "tcp",
             "-noreset"], pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as pipe:
            number = pipe.readline().strip()
        if not number:
            raise RuntimeError("Xvfb did not start")
        self.name = ":" + number

    def close(self):
        self.server.terminate()
        self.server.wait()


def ask_to_close(display, window):
    """What the cross of a window sends: WM_DELETE_WINDOW."""

    class ClientMessage(ctypes.Structure):
        _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("sent", ctypes.c_int),
                    ("display", ctypes.c_void_p), ("window", ctypes.c_ulong),
                    ("message", ctypes.c_ulong), ("format", ctypes.c_int),
                    ("data", ctypes.c_long * 5), ("room_of_the_union", ctypes.c_long * 24)]

    x11 = ctypes.CDLL("libX11.so.6")
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XInternAtom.restype = ctypes.c_ulong
    x11.XInternAtom.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int]
    x11.XSendEvent.argtypes = [ctypes.c_void_p, ctypes.c_ulong, ctypes.c_int, ctypes.c_long,
                               ctypes.c_void_p]
    x11.XCloseDisplay.argtypes = [ctypes.c_void_p]
    connection = x11.XOpenDisplay(display.encode())
    event = ClientMessage(type=33, window=window, format=32)  # ClientMessage
    event.message = x11.XInternAtom(connection, b"WM_PROTOCOLS", 0)
    event.data[0] = x11.XInternAtom(connection, b"WM_DELETE_WINDOW", 0)
    x11.XSendEvent(connection, window, 0, 0, ctypes.byref(event))
    x11.XCloseDisplay(connection)  # flushes


class Viewer:
    """A running tallow-view, and the hands of its user."""

    def __init__(self, program, folder, display):
        self.folder = folder
        self.log_file = folder / "log.csv"
        self.environment = dict(os.environ, DISPLAY=display.name, SDL_VIDEODRIVER="x11",
                                SDL_RENDER_DRIVER="software")
        with (folder / "stderr").open("w") as errors:
            self.process = subprocess.Popen(
                [program, str(folder / "scene.yaml"), "--log", str(self.log_file), "--screenshots",
                 str(folder)], env=self.environment, stderr=errors)
        self.window = int(wait_for(self.find_window, "the window").split()[0])
        self.do("windowfocus", self.window)

    def do(self, *words):
        return subprocess.run(["xdotool", *map(str, words)], env=self.environment,
                              capture_output=True, text=True).stdout

    def must_run(self):
        if self.process.poll() is not None:
            raise AssertionError("ended: " + (self.folder / "stderr").read_text())

    def find_window(self):
        self.must_run()
        return self.do("search", "--name", "^tallow: scene$")

    def rows(self):
        self.must_run()
        if not self.log_file.exists():
            return []
        whole_lines = self.log_file.read_text().rsplit("\n", 1)[0]
        return list(csv.DictReader(whole_lines.splitlines()))

    def wait(self, condition, what):
        """The last row of the log, once it is as wanted."""
        def last():
            rows = self.rows()
            return rows[-1] if rows and condition(rows[-1]) else None
        return wait_for(last, what)

    def rest(self, what="rest", condition=lambda row: True):
        return self.wait(lambda row: row["kind"] == "pass" and row["samples"] == "3"
                         and condition(row), what)

    def key(self, *names):
        for name in names:
            self.do("key", "--clearmodifiers", name)

    def mouse(self, *steps):
        for step in steps:
            if isinstance(step, tuple):
                self.do("mousemove", "--window", self.window, *step)
            else:
                self.do(*step.split())

    def screenshot(self):
        """Presses F12, and returns the name that was written, without extension."""
        before = set(self.folder.glob("scene_*.yaml"))
        self.key("F12")
        new = wait_for(lambda: set(self.folder.glob("scene_*.yaml")) - before, "a screenshot")
        return new.pop().with_suffix("")


def place(row):
    return [float(row[axis]) for axis in ("x_mm", "y_mm", "z_mm")]


def pixels(screenshot):
    return numpy.asarray(Image.open(screenshot.with_suffix(".png")).convert("RGB"), dtype=float)


class WindowTest(unittest.TestCase):
    program: str
    folder: pathlib.Path

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)
        cls.folder.mkdir(parents=True)
        (cls.folder / "scene.yaml").write_text(SCENE)
        cls.display = Display()
        cls.viewer = Viewer(cls.program, cls.folder, cls.display)

    @classmethod
    def tearDownClass(cls):
        cls.viewer.process.kill()
        cls.viewer.process.wait()
        cls.display.close()

    def test_1_makes_the_cache_and_comes_to_rest(self):
        row = self.viewer.rest()
        self.assertTrue((self.folder / "scene.tallow").exists())
        self.assertEqual((row["width"], row["height"]), ("160", "120"))
        self.assertEqual(place(row), [3, 3, 7])

    def test_2_keys_move_the_camera(self):
        for key, way in (("w", [-3, -3, -7]), ("d", [7, 0, -3]), ("e", [0, 1, 0])):
            start = place(self.viewer.rest())
            self.viewer.do("keydown", key)
            self.viewer.wait(lambda row: math.dist(place(row), start) > 0.05, "a move")
            self.viewer.do("keyup", key)
            end = place(self.viewer.rest("rest after a move",
                                         lambda row: math.dist(place(row), start) > 0.05))
            step = numpy.subtract(end, start)
            cosine = numpy.dot(step, way) / numpy.linalg.norm(step) / numpy.linalg.norm(way)
            self.assertGreater(cosine, 0.999, key)

    def test_3_mouse_orbits_and_turns(self):
        start = place(self.viewer.rest())
        self.viewer.mouse((80, 60), "mousedown 1", (95, 60), (100, 64), "mouseup 1")
        end = place(self.viewer.rest("an orbit", lambda row: place(row) != start))
        self.assertGreater(math.dist(start, end), 0.1)
        shot = pixels(self.viewer.screenshot())
        count = len(self.viewer.rows())
        self.viewer.mouse((80, 60), "mousedown 3", (84, 60), "mouseup 3")
        wait_for(lambda: len(self.viewer.rows()) > count, "frames of a turn")
        self.assertEqual(place(self.viewer.rest()), end)
        self.assertGreater(abs(pixels(self.viewer.screenshot()) - shot).mean(), 0.5)

    def test_4_screenshots_parse(self):
        row = self.viewer.rest()
        shot = self.viewer.screenshot()
        self.assertEqual(pixels(shot).shape, (120, 160, 3))
        with OpenEXR.File(str(shot.with_suffix(".exr")), separate_channels=True) as exr:
            channels = {name: numpy.array(c.pixels) for name, c in exr.channels().items()}
        for name in ("R", "multiple.R", "single.G", "specular.B", "exitance.R", "evaluations", "Z"):
            self.assertEqual(channels[name].shape, (120, 160), name)
        self.assertGreater(channels["multiple.R"].max(), 0)
        (camera,) = yaml.safe_load(shot.with_suffix(".yaml").read_text())["cameras"].values()
        self.assertLess(math.dist(camera["position"], place(row)), 1e-4)
        self.assertEqual(camera["resolution"], [160, 120])

    def test_5_digits_change_the_picture(self):
        shots = []
        for digit, aov in enumerate(("beauty", "multiple", "single", "specular", "exitance",
                                     "error", "evaluations"), 1):
            self.viewer.key(str(digit))
            if aov == "error":
                row = self.viewer.rest("certified sums", lambda row: row["largest_bound"] != "")
                self.assertLessEqual(float(row["largest_bound"]), 0.0101)
            shots.append(pixels(self.viewer.screenshot()))
        for i, shot in enumerate(shots):
            for other in shots[:i]:
                self.assertGreater(abs(shot - other).mean(), 0.5)
        self.viewer.key("1")

    def test_6_other_keys_change_the_picture(self):
        self.viewer.rest("beauty", lambda row: row["largest_bound"] == "")
        before = pixels(self.viewer.screenshot())
        self.viewer.key("bracketright")
        brighter = pixels(self.viewer.screenshot())
        self.assertGreater((brighter - before).mean(), 3)
        self.viewer.key("bracketleft")
        self.viewer.key("comma")
        self.viewer.rest("a finer tolerance", lambda row: row["tolerance"] == "0.005")
        self.viewer.key("period")
        self.viewer.rest("the tolerance before", lambda row: row["tolerance"] == "0.01")
        for key in ("plus", "m", "shift+m"):
            count = len(self.viewer.rows())
            self.viewer.do("key", key)
            wait_for(lambda: len(self.viewer.rows()) > count, "frames after " + key)
            self.viewer.rest()
            after = pixels(self.viewer.screenshot())
            self.assertGreater(abs(after - before).mean(), 0.1, key)
            before = after

    def test_7_the_window_may_be_resized(self):
        self.viewer.do("windowsize", self.viewer.window, 200, 90)
        self.viewer.rest("a frame of the new size",
                         lambda row: (row["width"], row["height"]) == ("200", "90"))

    def test_8_closing_ends_the_program_well(self):
        count = len(self.viewer.rows())
        self.viewer.do("keydown", "a")  # in the midst of drawing
        wait_for(lambda: len(self.viewer.rows()) > count, "a frame")
        ask_to_close(self.display.name, self.viewer.window)
        self.assertEqual(self.viewer.process.wait(PATIENCE_S), 0,
                         (self.folder / "stderr").read_text())


class ClosingEarlyTest(unittest.TestCase):
    """While pass one is under way: it would take minutes."""

    def test_stops_pass_one(self):
        folder = WindowTest.folder / "early"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "scene.yaml").write_text(re.sub("indirect_samples: 4", "indirect_samples: 65536",
                                                  SCENE))
        display = Display()
        viewer = Viewer(WindowTest.program, folder, display)
        try:
            ask_to_close(display.name, viewer.window)
            self.assertEqual(viewer.process.wait(PATIENCE_S), 0, (folder / "stderr").read_text())
            self.assertFalse((folder / "scene.tallow").exists())
        finally:
            viewer.process.kill()
            viewer.process.wait()
            display.close()


if __name__ == "__main__":
    WindowTest.program = sys.argv[1]
    WindowTest.folder = pathlib.Path(sys.argv[2]) / "window_test"
    unittest.main(argv=sys.argv[:1], failfast=True)
