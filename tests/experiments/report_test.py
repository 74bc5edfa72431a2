# SPDX-License-Identifier: Apache-2.0
"""The smoke suite runs, and its report is whole when it is opened on a phone.

    report_test.py [FOLDER]     where to run the suite; a temporary one otherwise
"""
import base64
import html
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from images import ROOT, run_process
from harness.suite import read_suite
from report_page import faults

SUITE = ROOT / "experiments/suites/smoke.yaml"


class Report(unittest.TestCase):
    folder = None  # of the command line

    @classmethod
    def setUpClass(cls):
        cls.own = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.own.cleanup)
        cls.out = (cls.folder or pathlib.Path(cls.own.name)) / "smoke"
        shutil.rmtree(cls.out, ignore_errors=True)
        code, out, err = run_process("run.py", SUITE, "--output", cls.out)
        if code != 0 or out != f"{cls.out}/report.html\n":
            raise AssertionError(f"exit code {code}: {out}{err}")
        cls.page = (cls.out / "report.html").read_text(encoding="utf-8")
        cls.plots = [path.stem for path in (cls.out / "plots").glob("*.png")]

    def faults_of(self, page):
        """Faults of a changed copy of the report, with the files that stand beside it."""
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder) / "report"
            shutil.copytree(self.out, copy, ignore=shutil.ignore_patterns("work"))
            (copy / "report.html").write_text(page, encoding="utf-8")
            return faults(copy / "report.html", self.plots)

    def test_the_report_is_whole(self):
        self.assertEqual(faults(self.out / "report.html", self.plots, self.out / "phone.png"), [])

    def test_published_reports_are_whole(self):
        for page in (ROOT / "docs/results").glob("*/report.html"):
            plots = [path.stem for path in (page.parent / "plots").glob("*.png")]
            self.assertEqual(faults(page, plots), [], page)

    def test_every_experiment_has_a_section_with_plots(self):
        sections = re.findall(r'<section id="section-\d+">.*?</section>', self.page, re.S)
        self.assertEqual(len(sections), len(read_suite(SUITE).experiments))
        for section in sections:
            title = re.search("<h2>(.*?)</h2>", section).group(1)
            self.assertRegex(section, '<figure class="plot"', f"{title}: no plot")

    def test_results_hold_every_experiment(self):
        rows = (self.out / "results.csv").read_text(encoding="utf-8").splitlines()[1:]
        kinds = {row.split(",")[0] for row in rows}
        self.assertEqual(kinds, {e["kind"] for e in read_suite(SUITE).experiments})

    def test_it_is_a_few_mebibytes_at_most(self):
        self.assertLess(len(self.page), 4 << 20)

    def test_a_missing_plot_is_found(self):
        first = re.search(r'<figure class="plot" id="(.*?)">.*?</figure>', self.page, re.S)
        self.assertIn(f"plot missing: {html.unescape(first.group(1))}",
                      self.faults_of(self.page.replace(first.group(0), "")))

    def test_a_broken_plot_is_found(self):
        broken = re.sub(r"(data:image/svg\+xml;base64,)[^\"]*", r"\1PHN2Zz4=", self.page, count=1)
        self.assertTrue(any(f.startswith("plot not drawn") for f in self.faults_of(broken)))

    def test_an_empty_plot_is_found(self):
        svg = base64.b64encode(b'<svg xmlns="http://www.w3.org/2000/svg" width="400" '
                               b'height="300"/>').decode()
        empty = re.sub(r"(data:image/svg\+xml;base64,)[^\"]*", r"\1" + svg, self.page, count=1)
        self.assertTrue(any(f.startswith("plot is empty") for f in self.faults_of(empty)))

    def test_dead_links_are_found(self):
        page = self.page.replace('href="results.csv"', 'href="nothing.csv"')
        page = page.replace('id="methods"', 'id="means"')
        found = self.faults_of(page)
        self.assertIn("dead link: nothing.csv", found)
        self.assertIn("dead link: #methods", found)

    def test_sideways_scrolling_is_found(self):
        wide = self.page.replace("<h1>", '<div style="width: 900px">wide</div><h1>')
        self.assertIn("scrolls sideways: ", " ".join(self.faults_of(wide)))

    def test_what_comes_from_outside_or_complains_is_found(self):
        page = self.page.replace("</main>", '<img alt="x" src="gone.png">'
                                 "<script>console.error('broken')</script></main>")
        found = " ".join(self.faults_of(page))
        for fault in ("picture not drawn: x", "picture not inside the page: x", "broken",
                      "1 scripts, style sheets or frames from outside"):
            self.assertIn(fault, found)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        Report.folder = pathlib.Path(sys.argv.pop(1))
    unittest.main()
