# SPDX-License-Identifier: Apache-2.0
"""A suite that was interrupted goes on where it was."""
import pathlib
import tempfile
import unittest

import images  # noqa: F401  finds harness
from harness.bench import Bench
from harness.journal import Journal
from harness.points import write_csv


class Resume(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)
        self.measured = []

    def measure(self, identity):
        journal = Journal(self.path / "journal.jsonl")
        return journal.get_or_measure(identity, lambda: self.measured.append(identity) or
                                      {"of": identity["x"]})

    def test_known_results_are_not_measured_again(self):
        for x in (1, 2, 1, 2):
            self.assertEqual(self.measure({"x": x, "y": "a"}), {"of": x})
        self.assertEqual([m["x"] for m in self.measured], [1, 2])

    def test_order_of_keys_does_not_matter_but_values_do(self):
        self.measure({"x": 1, "y": 2})
        self.measure({"y": 2, "x": 1})
        self.measure({"x": 1, "y": 3})
        self.assertEqual(len(self.measured), 2)

    def test_half_a_line_is_measured_again_alone(self):
        for x in (1, 2, 3):
            self.measure({"x": x})
        file = self.path / "journal.jsonl"
        file.write_bytes(file.read_bytes()[:-9])  # killed while it wrote the third
        self.measured.clear()
        for x in (1, 2, 3):
            self.assertEqual(self.measure({"x": x}), {"of": x})
        self.assertEqual(self.measured, [{"x": 3}])
        self.measured.clear()
        for x in (1, 2, 3):  # the rest of that line must not have spoilt the next one
            self.assertEqual(self.measure({"x": x}), {"of": x})
        self.assertEqual(self.measured, [])

    def test_bench_resumes_to_the_same_results(self):
        def all_points(fail_at=None):
            bench = Bench(self.path / "out", 1, say=lambda _: None)
            for n in range(4):
                def how(n=n):
                    if n == fail_at:
                        raise KeyboardInterrupt
                    self.measured.append(n)
                    return {"seconds": [n / 8], "relRMSE": [1.0]}, f"command {n}"
                bench.measure("hierarchy", "sphere-marble", "s", "n", n, how)
            write_csv(bench.points, self.path / "results.csv")

        with self.assertRaises(KeyboardInterrupt):
            all_points(fail_at=2)
        all_points()
        self.assertEqual(self.measured, [0, 1, 2, 3])
        first = (self.path / "results.csv").read_bytes()
        all_points()
        self.assertEqual(self.measured, [0, 1, 2, 3])
        self.assertEqual((self.path / "results.csv").read_bytes(), first)


if __name__ == "__main__":
    unittest.main()
