# SPDX-License-Identifier: Apache-2.0
"""Suite files: what is wrong with one is said with its place, before anything runs."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

from images import ROOT, run, run_process
from harness.cases import all_cases
from harness.suite import read_suite, read_yaml
from run import experiments_of

GOOD = """\
title: A suite
experiments:
  - kind: model
    cases: [sphere-marble]
"""


class Suites(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.file = pathlib.Path(self.folder.name) / "suite.yaml"

    def assert_fails(self, text, place, message):
        """The suite is refused with `message` at line:column `place`, and nothing was written."""
        self.file.write_text(text)
        output = pathlib.Path(self.folder.name) / "out"
        code, out, err = run("run.py", self.file, "--output", output)
        self.assertEqual((code, out), (3, ""), err)
        self.assertEqual(err, f"run.py: error: {self.file}:{place}: {message}\n")
        self.assertFalse(output.exists())

    def test_unknown_kind(self):
        self.assert_fails(GOOD.replace("kind: model", "kind: colour"), "3:5",
                          "kind: expected one of hierarchy, sampling, model, total, scaling, "
                          "reuse, single, got 'colour'")

    def test_unknown_key(self):
        self.assert_fails(GOOD + "repeats: 3\n", "5:1", "repeats: unknown key, expected one of "
                          "title, experiments, about, repeat, publish")

    def test_unknown_setting(self):
        self.assert_fails(GOOD + "    modles: [dipole]\n", "5:5", "modles: unknown key, expected "
                          "one of cases, models, indirect, no_indirect, tolerance, samples, "
                          "bounces, indirect_samples, difference_limit")

    def test_wrong_type(self):
        self.assert_fails(GOOD + "    samples: many\n", "5:5",
                          "samples: expected an integer, got 'many'")

    def test_wrong_choice(self):
        self.assert_fails(GOOD + "    indirect: [on, perhaps]\n", "5:5", "indirect: expected a "
                          "list, each one of on, off, got ['on', 'perhaps']")

    def test_value_out_of_range(self):
        self.assert_fails(GOOD + "    tolerance: 0\n", "5:5",
                          "tolerance: expected a number in (0, 1), got 0")
        self.assert_fails(GOOD + "repeat: 0\n", "5:1",
                          "repeat: expected an integer of at least 1, got 0")

    def test_unknown_case(self):
        self.assert_fails(GOOD.replace("marble", "cheese"), "4:5", "cases: sphere-cheese: expected "
                          "a medium of marble, skimmilk, skin1, dim, got 'cheese'")

    def test_cases_of_another_folder(self):
        self.assert_fails(GOOD.replace("sphere-marble", "elephant-marble"), "4:5", "cases: "
                          "elephant-marble: expected a medium of wholemilk, apple, potato, "
                          "chicken1, skin2, cream, chicken2, got 'marble'")
        self.assertNotIn("unseen", {case.folder.name for case in all_cases()})

    def test_repeated_key(self):
        self.assert_fails(GOOD + "title: Another\n", "5:1", "title: given twice")

    def test_missing_key(self):
        self.assert_fails("experiments: [{kind: model, cases: all}]\n", "1:1", "title: missing")
        self.assert_fails("title: A\nexperiments: [{kind: model}]\n", "2:15", "cases: missing")

    def test_experiment_without_kind(self):
        self.assert_fails("title: A\nexperiments: [model]\n", "2:1",
                          "experiments: expected mappings with a `kind`, got 'model'")

    def test_no_yaml(self):
        self.assert_fails("title: [\n", "2:1",
                          "expected the node content, but found '<stream end>'")

    def test_no_such_suite(self):
        code, out, err = run_process("run.py", "nonsense")
        self.assertEqual((code, out), (3, ""))
        self.assertRegex(err, r"^run\.py: error: suite: expected a file \*\.yaml or one of "
                              r"[a-z, -]*\bmodel-error, [a-z, -]*, got 'nonsense'\n$")
        self.assertEqual(run_process("run.py", "nonsense", "--needs"), (code, out, err))

    def test_no_such_file(self):
        code, out, err = run_process("run.py", "nonsense.yaml")
        self.assertEqual((code, out), (3, ""))
        self.assertEqual(err, "run.py: error: nonsense.yaml: No such file or directory\n")

    def test_a_python_without_packages(self):
        done = subprocess.run([sys.executable, "-I", "-S", ROOT / "experiments/run.py", "quick"],
                              capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
        self.assertRegex(done.stderr, r"^run\.py: error: .*: expected a Python with the packages "
                                      r"of experiments/requirements\.txt, got none called \w+; "
                                      r"experiments/python experiments/run\.py has them\n$")

    def test_words_and_numbers_of_yaml_1_2(self):
        self.file.write_text(GOOD + "    indirect: [on, off]\n    tolerance: 1e-3\n")
        experiment = read_yaml(self.file)["experiments"][0]
        self.assertEqual(experiment["indirect"], ["on", "off"])
        self.assertEqual(experiment["tolerance"], 0.001)

    def test_needs(self):
        self.file.write_text(GOOD)
        self.assertEqual(run("run.py", self.file, "--needs"), (0, "\n", ""))
        self.file.write_text(GOOD.replace("sphere", "bunny"))
        self.assertEqual(run("run.py", self.file, "--needs"), (0, "fetch\n", ""))
        self.file.write_text(GOOD.replace("[sphere-marble]", "all"))
        self.assertEqual(run("run.py", self.file, "--needs"), (0, "fetch\n", ""))

    def test_shipped_suites_are_right(self):
        for path in sorted((ROOT / "experiments/suites").glob("*.yaml")):
            self.assertTrue(experiments_of(read_suite(path), None), path)


if __name__ == "__main__":
    unittest.main()
