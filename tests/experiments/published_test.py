# SPDX-License-Identifier: Apache-2.0
"""Numbers in documents come from published results, and stale ones are found."""
import pathlib
import tempfile
import unittest

from images import run_process
from harness import published
from harness.points import Point, write_csv
from harness.suite import InputError

TEMPLATES = """\
times:
  suite: full
  text: "Ours: {ours}; theirs: {theirs}, {ratio} times as long; 1 % takes {at_one}."
  numbers:
    ours: {of: {experiment: total, series: ours, value: 0.1}, quantity: seconds, format: seconds}
    theirs: {of: {experiment: total, series: theirs}, quantity: seconds, format: seconds}
    ratio: {quotient: [theirs, ours]}
    at_one: {of: {experiment: total, series: ours}, quantity: seconds, at: {relRMSE: 0.01},
             format: seconds}
errors:
  suite: full
  table: {of: {experiment: model}, rows: case, columns: series, quantity: relRMSE, format: percent,
          corner: relRMSE}
twice:
  suite: full
  text: "{x}"
  numbers: {x: {of: {experiment: total}, quantity: seconds}}
"""

README = """\
# Title
Before.
<!-- results: times -->
what stood here
over two lines
<!-- /results -->
Between.

<!-- results: errors -->
<!-- /results -->
After.
"""

FRESH = """\
# Title
Before.
<!-- results: times -->
Ours: 0.2 s; theirs: 5 s, 25 times as long; 1 % takes 2 s.
<!-- /results -->
Between.

<!-- results: errors -->
| relRMSE | dipole | transport |
| --- | --- | --- |
| sphere | 40 % | 2.5 % |
| bunny |  | 7.6 % |
<!-- /results -->
After.
"""


def points():
    def point(experiment, case, series, value, **quantities):
        return Point(experiment, case, series, "tolerance", value, quantities, "command")
    return [point("total", "c", "ours", 0.1, seconds=[0.3, 0.2, 0.1], relRMSE=[0.1]),
            point("total", "c", "ours", 0.001, seconds=[20.0], relRMSE=[0.001]),
            point("total", "c", "theirs", 64, seconds=[5.0]),
            point("model", "sphere", "dipole", "", relRMSE=[0.4]),
            point("model", "sphere", "transport", "", relRMSE=[0.025]),
            point("model", "bunny", "transport", "", relRMSE=[0.0761])]


class Published(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        (self.root / "experiments").mkdir()
        (self.root / "experiments/published.yaml").write_text(TEMPLATES)
        self.readme = self.root / "README.md"
        self.readme.write_text(README)
        self.out = self.root / "out"
        (self.out / "plots").mkdir(parents=True)
        (self.out / "plots/a.png").write_text("png")
        (self.out / "report.html").write_text("page")
        write_csv(points(), self.out / "results.csv")

    def publish(self):
        return published.publish("full", self.out, self.root)

    def refused(self, old, new, *words):
        """README with `old` replaced is refused with a message that holds the words."""
        self.readme.write_text(README.replace(old, new))
        with self.assertRaises(InputError) as caught:
            published.stale(self.root)
        for word in words:
            self.assertIn(word, str(caught.exception))

    def test_numbers_and_tables_are_generated(self):
        self.assertEqual(self.publish(), [self.readme])
        self.assertEqual(self.readme.read_text(), FRESH)
        for name in ("report.html", "results.csv", "plots/a.png"):
            self.assertTrue((self.root / "docs/results/full" / name).exists(), name)

    def test_fresh_documents_stay_as_they_are(self):
        self.publish()
        self.assertEqual(published.stale(self.root), [])
        self.assertEqual(self.publish(), [])

    def test_a_typed_number_is_stale(self):
        self.publish()
        self.readme.write_text(FRESH.replace("2.5 %", "2.4 %"))
        self.assertEqual(published.stale(self.root), [self.readme])

    def test_new_results_make_documents_stale(self):
        self.publish()
        csv = self.root / "docs/results/full/results.csv"
        csv.write_text(csv.read_text().replace("0.0761", "0.08"))
        self.assertEqual(published.stale(self.root), [self.readme])

    def test_documents_below_docs_count(self):
        self.publish()
        page = self.root / "docs/deep/PAGE.md"
        page.parent.mkdir()
        page.write_text(README)
        self.assertEqual(published.stale(self.root), [page])

    def test_plots_that_are_gone_do_not_stay_published(self):
        self.publish()
        (self.out / "plots/a.png").rename(self.out / "plots/b.png")
        self.publish()
        self.assertEqual([p.name for p in (self.root / "docs/results/full/plots").iterdir()],
                         ["b.png"])

    def test_what_cannot_be_generated_is_said(self):
        self.refused("", "", "docs/results/full/results.csv", "publish the suite first")
        self.publish_csv()
        self.refused("results: times", "results: tomes", "no entry tomes")
        self.refused("results: times", "results: twice", "published.yaml:14:1", "expected one row")
        self.refused("<!-- /results -->\nBetween", "Between", "README.md:3", "<!-- /results -->")
        self.refused("Before.", "<!-- /results -->", "README.md:2", "without a beginning")

    def publish_csv(self):
        (self.root / "docs/results/full").mkdir(parents=True)
        write_csv(points(), self.root / "docs/results/full/results.csv")

    def test_the_command_checks_this_repository(self):
        self.assertEqual(run_process("run.py", "--check-published"), (0, "", ""))


if __name__ == "__main__":
    unittest.main()
