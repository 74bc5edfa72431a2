# SPDX-License-Identifier: Apache-2.0
"""Fits, readings between points, words, the launcher, settings and sections of experiments.

    experiments/python tests/experiments/kinds_test.py
"""
import importlib
import math
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "experiments"))

from harness import fits, programs, words  # noqa: E402
from harness.bench import Bench  # noqa: E402
from harness.points import Point  # noqa: E402
from harness.suite import InputError, checked, read_suite, read_yaml  # noqa: E402

KINDS = "hierarchy", "sampling", "scaling", "reuse", "single"


class PowerLaw(unittest.TestCase):
    def test_finds_an_exact_power(self):
        law = fits.power_law([1, 10, 100, 1000], [3 * x ** 0.75 for x in (1, 10, 100, 1000)])
        self.assertAlmostEqual(law.exponent, 0.75, 12)
        self.assertAlmostEqual(law.factor, 3, 12)
        self.assertAlmostEqual(law.error, 0, 12)
        self.assertAlmostEqual(law(50), 3 * 50 ** 0.75, 9)

    def test_standard_error_is_that_of_a_slope(self):
        # Worked by hand: u = 0, 1, 2; v = 0, 1, 1. Slope 1/2, residuals -1/6, 1/3, -1/6, whose
        # squares add up to 1/6; over one degree of freedom and sum (u - 1)^2 = 2: sqrt(1/12).
        law = fits.power_law([1, math.e, math.e ** 2], [1, math.e, math.e])
        self.assertAlmostEqual(law.exponent, 0.5, 12)
        self.assertAlmostEqual(law.error, math.sqrt(1 / 12), 12)

    def test_two_points_have_no_standard_error(self):
        law = fits.power_law([1, 4], [1, 2])
        self.assertAlmostEqual(law.exponent, 0.5, 12)
        self.assertTrue(math.isnan(law.error))
        self.assertIn("two points", law.words())

    def test_one_x_has_no_power(self):
        self.assertIsNone(fits.power_law([], []))
        self.assertIsNone(fits.power_law([5], [1]))
        self.assertIsNone(fits.power_law([5, 5, 5], [1, 2, 3]))


class BetweenPoints(unittest.TestCase):
    def test_powers_are_read_exactly(self):
        x = [0.1, 0.01, 0.001]
        self.assertAlmostEqual(fits.y_at(x, [v ** -2 for v in x], 0.02), 2500, 6)

    def test_nothing_is_read_beyond_the_points(self):
        self.assertIsNone(fits.y_at([1, 2], [1, 2], 2.1))
        self.assertIsNone(fits.y_at([1, 2], [1, 2], 0.9))
        self.assertIsNone(fits.y_at([], [], 1))
        self.assertAlmostEqual(fits.y_at([1, 2], [3, 5], 2), 5, 12)

    def test_of_equal_x_the_least_y_counts(self):
        self.assertAlmostEqual(fits.y_at([1, 1, 1], [5, 3, 4], 1), 3, 12)

    def test_points_without_numbers_are_left_out(self):
        def point(quantities):
            return Point("e", "c", "s", "p", 1, quantities)
        points = [point({}), point({"relRMSE": [0.1], "seconds": [1, 3, 2]}),
                  point({"relRMSE": [0.001], "seconds": [200]}),
                  point({"relRMSE": [0], "seconds": [1000]})]
        self.assertAlmostEqual(fits.median_at(points, 0.01), 20, 9)
        self.assertIsNone(fits.median_at(points, 0.2))


class Words(unittest.TestCase):
    def test_numbers(self):
        self.assertEqual(words.seconds(0.00213), "2.1 ms")
        self.assertEqual(words.seconds(0.1), "0.1 s")
        self.assertEqual(words.seconds(132.4), "130 s")
        self.assertEqual(words.percent(0.0123), "1.2 %")
        self.assertEqual(words.count(285_578), "286k")
        self.assertEqual(words.count(1_000_000), "1M")
        self.assertEqual(words.count(999), "999")
        self.assertEqual(words.memory(2048), "2 GiB")
        self.assertEqual(words.significant(0), "0")
        self.assertEqual(words.significant(0.00013), "0.00013")
        self.assertEqual(words.listed(["a", "b", "c"]), "a, b and c")
        self.assertEqual(words.listed(["a"]), "a")


class Launch(unittest.TestCase):
    def run_python(self, code, **options):
        python = pathlib.Path(sys.executable)
        return programs.run(python.name, "-S", "-c", code, bin=python.parent, stats=False,
                            **options)

    def test_peak_is_the_program_s_own(self):
        ballast = bytearray(300 * 2 ** 20)  # this process is larger than the one that is run
        small = self.run_python("pass")
        large = self.run_python("x = bytearray(200 * 2 ** 20)")
        del ballast
        self.assertLess(small.peak_mib, 100)
        self.assertGreater(large.peak_mib, small.peak_mib + 150)
        self.assertLess(large.peak_mib, 300)

    def test_output_and_failure(self):
        self.assertEqual(self.run_python("print(6 * 7)").stdout, "42\n")
        with self.assertRaisesRegex(programs.ProgramFailed, "exit code 3: no such luck"):
            self.run_python("import sys; sys.stderr.write('no such luck'); sys.exit(3)")
        with self.assertRaisesRegex(programs.ProgramFailed, "No such file"):
            programs.run("no-such-program", stats=False)

    def test_too_slow_is_stopped(self):
        with self.assertRaises(programs.ProgramFailed):
            self.run_python("import time; time.sleep(60)", timeout=0.2)


class Settings(unittest.TestCase):
    def settings(self, kind, text):
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            file.write(text)
            file.flush()
            module = importlib.import_module(f"harness.kinds.{kind}")
            return checked(module.Settings, read_yaml(file.name))

    def test_defaults_are_valid(self):
        for kind in KINDS:
            self.settings(kind, "cases: [sphere-marble]")

    def test_places_of_bad_values(self):
        bad = {"hierarchy": "tolerances: [0.01, 2]", "sampling": "methods: [cells, voroni]",
               "scaling": "threads: []", "reuse": "light_scale: [1, 1]",
               "single": "reference_depths: 64"}
        for kind, line in bad.items():
            key = line.split(":")[0]
            with self.assertRaisesRegex(InputError, rf"\.yaml:2:1: {key}: expected .*, got "):
                self.settings(kind, f"cases: [sphere-marble]\n{line}\n")

    def test_unknown_case(self):
        for kind in KINDS:
            with self.assertRaisesRegex(InputError, "sphere-gold"):
                self.settings(kind, "cases: [sphere-gold]")

    def test_suite_of_kinds(self):
        suite = read_suite(ROOT / "experiments/suites/kinds-quick.yaml")
        self.assertEqual([e["kind"] for e in suite.experiments], list(KINDS))


def quantities_at(value):
    """What a measurement may have found: error falls with cost as a power."""
    size = float(value) if isinstance(value, (int, float)) else 1.0
    result = {name: [0.3 / (1 + size)] for name in ("relRMSE", "p99", "max", "relRMSE_picture")}
    result |= {name: [0.01 * (1 + size), 0.02 * (1 + size)] for name in ("seconds", "peak_mib")}
    return result | {"bias": [-0.01], "samples": [1000 + size], "seconds_exitance": [0.01]}


class InventedBench(Bench):
    """Finds quantities_at(value) without measuring."""

    def measure(self, experiment, case, series, parameter, value, how, **identity):
        return super().measure(experiment, case, series, parameter, value,
                               lambda: (quantities_at(value), "a command"), **identity)


class Sections(unittest.TestCase):
    """From whatever was measured a section follows, its words and plots without a hole."""

    def check(self, kind, bench):
        module = importlib.import_module(f"harness.kinds.{kind}")
        settings = module.Settings()
        module.measure(settings, bench)
        section = module.section(settings, bench)
        self.assertTrue(section.plots)
        for words_of in (section.title, section.text, *(p.caption for p in section.plots)):
            self.assertNotRegex(words_of, r"nan|None|[{}]")
        for plot in section.plots:
            self.assertTrue(plot.command)
            for axes in plot.figure.axes:
                self.assertTrue(axes.get_ylabel())
                self.assertTrue(axes.lines or axes.patches)
        for table in section.tables:
            self.assertTrue(table.rows)
            for row in table.rows:
                self.assertEqual(len(row), len(table.columns))
        names = [p.name for p in section.plots]
        self.assertEqual(len(names), len(set(names)))

    def test_sections(self):
        for kind in KINDS:
            with self.subTest(kind), tempfile.TemporaryDirectory() as folder:
                bench = InventedBench(pathlib.Path(folder), repeat=2, say=lambda _: None)
                self.check(kind, bench)
                measured = len(bench.points)
                self.check(kind, bench)  # everything is in the journal
                self.assertEqual(len(bench.points), 2 * measured)


class TruthOfSingleScattering(unittest.TestCase):
    def words_of(self, **quantities):
        single = importlib.import_module("harness.kinds.single")
        return single.difference_words(Point("single", "c", "s", "p", 1, {
            name: [value] for name, value in quantities.items()}))

    def test_says_what_the_noise_allows(self):
        self.assertIn("no more than the truth's noise of 5 %",
                      self.words_of(relRMSE=0.0, noise=0.05))
        self.assertIn("relRMSE of 62 %, the truth's noise of 5 % taken off",
                      self.words_of(relRMSE=0.62, noise=0.05))
        self.assertIn("noise included", self.words_of(relRMSE=0.62))


if __name__ == "__main__":
    unittest.main()
