# SPDX-License-Identifier: Apache-2.0
"""Total error against total time: extrapolation, the table's cells, what is said of gaps.

    experiments/python tests/experiments/total_test.py
"""
import math
import pathlib
import sys
import tempfile
import types
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "experiments"))

import run  # noqa: E402
from harness.bench import Bench  # noqa: E402
from harness.kinds import model, total  # noqa: E402
from harness.points import Point  # noqa: E402
from harness.suite import InputError, checked, read_yaml  # noqa: E402


def point(series, value, **quantities):
    return Point("total", "sphere-marble", series, "tolerance", value,
                 {name: list(numbers) for name, numbers in quantities.items()}, "a command")


OURS = [point("transport", 0.1, seconds=[1], relRMSE=[0.16]),
        point("transport", 0.01, seconds=[3, 4, 5], relRMSE=[0.04] * 3),
        point("transport", 0.003, seconds=[64], relRMSE=[0.03])]
MITSUBA = [point("mitsuba", 60, seconds=[60], relRMSE=[0.5], own_noise=[0.5], floor=[0.2]),
           point("mitsuba", 120, seconds=[100], relRMSE=[0.2], own_noise=[0.2], floor=[0.05])]
BURLEY = [point("cycles-burley", 120, seconds=[100], relRMSE=[0.62], own_noise=[0.02],
                floor=[0.6])]


def settings_of(text):
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(text)
        file.flush()
        return checked(total.Settings, read_yaml(file.name))


class Lines(unittest.TestCase):
    def test_noise_falls_as_the_root_of_time(self):
        line = total.NoiseLine(100, 0.2)
        self.assertAlmostEqual(line.error_at(400), 0.1, 12)
        self.assertAlmostEqual(line.seconds_to(0.02), 10_000, 6)
        times, errors = line.beyond(least=0.01)
        self.assertAlmostEqual(times[0], 100, 6)
        self.assertAlmostEqual(times[-1], 40_000, 4)
        self.assertAlmostEqual(errors[-1], 0.01, 12)

    def test_nothing_is_drawn_beyond_what_is_reached(self):
        self.assertEqual(total.NoiseLine(100, 0.005).beyond(least=0.01), ([], []))

    def test_floor_is_never_passed(self):
        line = total.NoiseLine(10, 0.03, floor=0.04)
        self.assertAlmostEqual(line.error_at(10), 0.05, 12)
        self.assertAlmostEqual(line.seconds_to(0.05), 10, 9)
        self.assertTrue(math.isinf(line.seconds_to(0.04)))
        times, errors = line.beyond(least=0.01)
        self.assertAlmostEqual(times[-1], 10 * total.BEYOND, 6)
        self.assertGreater(min(errors), 0.04)

    def test_line_of_the_longest_measurement(self):
        self.assertEqual(total.noise_line(MITSUBA, "mitsuba"), total.NoiseLine(100, 0.2, 0.0))
        self.assertEqual(total.noise_line(BURLEY, "cycles-burley").floor, 0.6)

    def test_nearest_by_ratio(self):
        rows = [{"seconds": 1}, {"seconds": 10}]
        self.assertEqual(total.nearest(rows, 3)["seconds"], 1)
        self.assertEqual(total.nearest(rows, 4)["seconds"], 10)


class Cells(unittest.TestCase):
    def test_ours_is_read_between_tolerances(self):
        self.assertEqual(total.ours_to(OURS, 0.08), "2 s")  # 1 s .. 4 s, 16 % .. 4 %
        self.assertEqual(total.ours_to(OURS, 0.2), "at most 1 s")
        self.assertEqual(total.ours_to(OURS, 0.02), "not reached: 3 % at the finest tolerance")

    def test_a_floor_is_one_only_where_the_line_is_flat(self):
        ended = [*OURS, point("transport", 0.001, seconds=[70], relRMSE=[0.0299])]
        self.assertEqual(total.ours_to(ended, 0.02), "not reached: floor 3 %")
        self.assertFalse(total.has_ended(OURS))  # 4 % to 3 %
        self.assertFalse(total.has_ended(OURS[:1]))

    def test_others(self):
        line = total.noise_line(MITSUBA, "mitsuba")
        self.assertEqual(total.other_to(line, 0.4), "25 s")
        self.assertEqual(total.other_to(line, 0.4, first=60), "at most 60 s")
        self.assertEqual(total.other_to(line, 0.1), "400 s (extrapolated)")
        self.assertEqual(total.other_to(line, 0.01), "11 h (extrapolated)")
        burley = total.noise_line(BURLEY, "cycles-burley")
        self.assertEqual(total.other_to(burley, 0.1), "not reached: floor 60 %")

    def test_words_of_close_points_are_joined(self):
        close = point("transport", 0.001, seconds=[65], relRMSE=[0.029])
        self.assertEqual([[p.value for p in group] for group in total.crowds([close, *OURS])],
                         [[0.1], [0.01], [0.003, 0.001]])

    def test_table_and_plot(self):
        settings = total.Settings(models=["transport"], renderers=["mitsuba", "cycles-burley"])
        points = OURS + MITSUBA + BURLEY
        table = total.table_of(settings, "sphere-marble", points)
        self.assertEqual([row[0] for row in table.rows],
                         ["tallow, transport", "mitsuba", "cycles-burley"])
        self.assertEqual([row[-1] for row in table.rows],
                         ["3 %, still falling", "no floor", "60 %"])
        self.assertTrue(all(len(row) == len(table.columns) for row in table.rows))
        axes = total.plot_of(settings, "sphere-marble", points).figure.axes[0]
        words = " ".join(text.get_text() for text in axes.texts)
        self.assertIn("finest tolerance: 3 %", words)
        self.assertIn("bias: 60 %", words)
        dashed = [line for line in axes.lines if line.get_linestyle() == "--"]
        self.assertEqual(len(dashed), 2)
        self.assertAlmostEqual(dashed[0].get_ydata()[-1], 1, 9)  # per cent


class InventedBench(Bench):
    """Finds errors without measuring."""

    def measure(self, experiment, case, series, parameter, value, how, **identity):
        numbers = {name: [0.1 + value] for name in ("seconds", "relRMSE", "own_noise", "floor")}
        return super().measure(experiment, case, series, parameter, value,
                               lambda: (numbers, "a command"), **identity)


class Missing(unittest.TestCase):
    """What is not there is said, and nothing falls over."""

    def bench(self, folder, said):
        return Bench(pathlib.Path(folder), 1, said.append)

    def test_without_a_truth(self):
        said = []
        with tempfile.TemporaryDirectory() as folder, \
                mock.patch("harness.cases.REFERENCES", pathlib.Path(folder)):
            bench, settings = self.bench(folder, said), total.Settings(renderers=[])
            total.measure(settings, bench)
            section = total.section(settings, bench)
        self.assertIn("holds no truth for them: sphere-marble", section.text)
        self.assertFalse(section.plots or section.tables or bench.points)
        self.assertIn("no reference", said[0])

    def test_renderers_that_are_not_there(self):
        truth = types.SimpleNamespace(noise2=0.0004, mean=1.0)
        settings = total.Settings(renderers=["mitsuba", "tallow-reference"], seconds=1)

        def reason(renderer):
            return "no LLVM" if renderer == "mitsuba" else ""
        with tempfile.TemporaryDirectory() as folder, \
                mock.patch("harness.cases.REFERENCES", pathlib.Path(folder)), \
                mock.patch.object(total, "_truth", lambda path: truth), \
                mock.patch.object(total, "unavailable", reason):
            (pathlib.Path(folder) / "sphere-marble.exr").touch()
            said = []
            for entries in (13, 13):  # the second time everything is in the journal
                bench = InventedBench(pathlib.Path(folder), 1, said.append)
                total.measure(settings, bench)
                self.assertEqual(len(bench.journal.results), entries)
            section = total.section(settings, bench)
        self.assertIn("total: mitsuba is left out: no LLVM", said)
        self.assertIn("mitsuba was left out of sphere-marble: no LLVM.", section.text)
        self.assertIn("Noise of the truth: sphere-marble 2 %.", section.text)
        self.assertEqual([plot.name for plot in section.plots], ["total-sphere-marble"])
        self.assertEqual([row[0] for row in section.tables[0].rows],
                         ["tallow, body-aware", "tallow, transport", "tallow-reference"])

    def test_without_bpy(self):
        with mock.patch.dict("os.environ", {total.BPY_PYTHON: "/no/such/python"}):
            reason = total.unavailable("cycles-burley")
        self.assertIn("No such file", reason)
        self.assertIn(total.BPY_PYTHON, reason)

    def test_without_mitsuba(self):
        attempts = {**total.ATTEMPTS, "mitsuba": "raise ImportError('no mitsuba here')"}
        total._probe.cache_clear()
        with mock.patch.object(total, "ATTEMPTS", attempts):
            self.assertIn("no mitsuba here", total.unavailable("mitsuba"))
        total._probe.cache_clear()


class SuiteSettings(unittest.TestCase):
    def test_bad_values(self):
        for line in ("tolerances: [2]", "seconds: 0", "renderers: [pbrt]", "samples: 0"):
            with self.assertRaisesRegex(InputError, rf"\.yaml:2:1: {line.split(':')[0]}: expected"):
                settings_of(f"cases: [sphere-marble]\n{line}\n")
        self.assertEqual(settings_of("renderers: []").renderers, [])

    def test_mitsuba_is_needed_only_where_it_is_used(self):
        suites = ROOT / "experiments/suites"
        self.assertNotIn("mitsuba", run.needs(suites / "quick.yaml"))
        self.assertIn("mitsuba", run.needs(suites / "full.yaml"))


class ModelSettings(unittest.TestCase):
    def test_indirect_light(self):
        def flags(indirect, **settings):
            settings = model.Settings(["sphere-marble"], **settings)
            return " ".join(model._Comparison(settings, None, None, None, "transport",
                                              indirect)._flags()[0])
        self.assertEqual(flags("on"), "--tolerance 0.005")
        self.assertIn("settings.bounces=0", flags("off", bounces=3, indirect_samples=8))
        self.assertIn("settings.bounces=3 --set settings.indirect_samples=8",
                      flags("on", bounces=3, indirect_samples=8))


if __name__ == "__main__":
    unittest.main()
