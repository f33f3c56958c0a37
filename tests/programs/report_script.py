# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""scripts/report.py from the outside, on a small record of cbvh_bench.

usage: report_script.py PATH/TO/cbvh_bench
"""

import json
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from html.parser import HTMLParser
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts/report.py"
BENCH = sys.argv.pop(1)
sys.path.insert(0, str(SCRIPT.parent))
import report_data  # noqa: E402
import report_figures  # noqa: E402
import report_hard_cases  # noqa: E402
import report_sections  # noqa: E402
from report_relations import relations  # noqa: E402

SECTIONS = (
    "relations",
    "figure10",
    "figure11",
    "pictures",
    "figure16",
    "figure17",
    "tradeoffs",
    "errors",
    "bins",
    "growth",
    "entrances",
    "robustness",
    "hard",
    "all",
)


class Page(HTMLParser):
    """Checks that tags nest, and collects what refers to something."""

    VOID = {"meta", "img", "source", "br"}

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.references, self.alternatives = [], [], [], 0
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.ids += [found["id"]] if "id" in found else []
        self.references += [found[name] for name in ("src", "srcset", "href") if name in found]
        self.alternatives += tag == "img" and bool(found.get("alt"))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> closes something else"


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.records = Path(cls.temporary.name) / "records"
        subprocess.run(
            [
                BENCH,
                "--scene",
                "cube",
                "--level",
                "2,6",
                "--view",
                "full,close",
                "--representation",
                "naive,cvoxel,cleaf,cgrid^2",
                "--frame-level",
                "2,3",
                "--rays",
                "300",
                "--repeat",
                "3",
                "--size",
                "48x48",
                "--check",
                "leaks,shadows",
                "--check-rays",
                "2000",
                "--pictures",
                str(cls.records / "pictures/cube"),
                "--json",
                str(cls.records / "cube_L2-6.json"),
            ],
            check=True,
            capture_output=True,
        )

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def run_script(self, *words):
        return subprocess.run(
            [sys.executable, "-B", str(SCRIPT), *map(str, words)], capture_output=True, text=True, timeout=200
        )

    def test_the_page_is_whole_and_refers_to_nothing_outside(self):
        # A damaged record is named in one line and left out.
        folder = Path(self.temporary.name) / "damaged"
        shutil.copytree(self.records, folder)
        text = (folder / "cube_L2-6.json").read_text()
        (folder / "short_L4.json").write_text(text[:1000])
        done = self.run_script(folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, "report.py: warning: short_L4.json: truncated or no JSON; left out\n")

        html = (folder / "report.html").read_text()
        page = Page(html)
        self.assertEqual(page.open, [])
        self.assertEqual([name for name in page.ids if name in SECTIONS], list(SECTIONS))
        for reference in page.references:
            self.assertTrue(reference.startswith("data:") or reference[1:] in page.ids, reference[:60])
        self.assertGreater(page.alternatives, 10)
        self.assertIn("short_L4.json", html)
        self.assertIn("Noise.", html)
        self.assertIn("Leaks and self-shadowing", html)
        self.assertGreaterEqual(html.count("1e-4 diagonals"), 8 * 2)
        self.assertIn("No data", html, "no trex, no frog: the page says so")
        self.assertIn("cbvh_bench --scene cube --level 2,6", html)
        self.assertNotIn(str(folder), html)
        for section in SECTIONS[:-1]:
            begin = html.index(f'id="{section}"')
            body = html[begin : html.find("</section>", begin)]
            self.assertTrue("Made by" in body or "No data" in body, section)
        tables = (folder / "tables.md").read_text()
        self.assertIn("| GRID |", tables)
        self.assertIn("| relation | paper | ours | |", tables)

    def test_bad_folders_get_one_line(self):
        empty = Path(self.temporary.name) / "empty"
        empty.mkdir()
        for folder, said in ((empty, "no measurements"), (empty / "none", "no such folder")):
            done = self.run_script(folder)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn(said, done.stderr)

    def test_a_run_against_itself_does_not_differ(self):
        data = report_data.Data(self.records)
        apart = report_data.compare_runs(data, report_data.Data(self.records))
        self.assertGreater(apart["count"], 10)
        self.assertEqual((apart["max"], apart["beyond"]), (0, 0))
        self.assertIsNotNone(report_data.noise(data))

    def test_errors_against_a_finer_mesh_come_from_the_job_that_has_them(self):
        folder = Path(self.temporary.name) / "finer"
        shutil.copytree(self.records, folder)
        value = report_sections.speed_value("coherent")
        points, finer = report_sections.scatter_points(report_data.Data(folder), "cube", "full", value)
        self.assertFalse(finer)
        self.assertEqual({row.level for row, _, _ in points}, {6})
        record = json.loads((folder / "cube_L2-6.json").read_text())
        for group in record["groups"]:
            for result in group["results"]:
                for view in result["views"]:
                    view["errors_to_reference_level"] = view["errors"]
        (folder / "levels_L2-6.json").write_text(json.dumps(record))
        points, finer = report_sections.scatter_points(report_data.Data(folder), "cube", "full", value)
        self.assertTrue(finer)
        self.assertEqual({(row.level, row.job) for row, _, _ in points}, {(2, "levels"), (6, "levels")})

    def test_more_rounds_make_a_median_surer(self):
        few, many = ({"relative_to_grid": {"spread": 0.027}, "seconds": [1] * n} for n in (4, 16))
        self.assertAlmostEqual(report_data.uncertainty(few), 0.025)
        self.assertAlmostEqual(report_data.uncertainty(many), 0.0125)

    def test_relations_are_judged_by_the_numbers(self):
        folder = Path(self.temporary.name) / "judged"
        folder.mkdir()
        record = json.loads((self.records / "cube_L2-6.json").read_text())
        for name, part, holds in (("small", 0.31, True), ("large", 0.32, False)):
            results = next(group for group in record["groups"] if group["level"] == 6)["results"]
            grid = next(r for r in results if r["representation"] == "GRID")["memory"]["live_bytes"]
            next(r for r in results if r["representation"] == "cLEAF^2")["memory"]["live_bytes"] = int(part * grid)
            (folder / "cube_L6.json").write_text(json.dumps(record))
            table = {r.claim: r for r in relations(report_data.Data(folder))}
            claim = "cube: memory of cLEAF^2 at level 6 as a part of GRID at level 6"
            self.assertEqual(table[claim].holds, holds, name)
            self.assertEqual(bool(table[claim].reason), not holds, "what does not hold has a reason or says that it has none")
            self.assertIn(f"{100 * part:.1f}%", table[claim].ours)
            missing = next(r for r in table.values() if re.search("frog|level 8", r.claim))
            self.assertIsNone(missing.holds, "what was not measured neither holds nor fails")

    def test_the_table_of_hard_cases_says_what_their_tests_said(self):
        folder = Path(self.temporary.name) / "hard_cases"
        folder.mkdir()
        for isa, result in (("sse2", ""), ("avx2", '<failure message="t is &lt; 0"/>'), ("avx512", "<skipped/>")):
            (folder / f"{isa}.xml").write_text(
                f'<testsuites><testsuite><testcase name="AlongAxes/cLEAF_{isa}" classname="HardCases/HardRays">{result}'
                '<properties><property name="property" value="rays &gt; boxes"/></properties></testcase></testsuite></testsuites>'
            )
        (folder / "stopped.xml").write_text("<testsuites><testsuite>")
        (case,) = report_hard_cases.read(folder)
        self.assertEqual((case.name, case.sentence), ("HardRays.AlongAxes", "rays > boxes"))
        self.assertEqual([case.results["cLEAF", isa] for isa in ("sse2", "avx2", "avx512")], ["passed", "failed", "skipped"])
        html = report_hard_cases.section(folder)
        self.assertIn("fails: avx2", html)
        self.assertIn("rays &gt; boxes", html)
        self.assertIn("1 of 3 tests pass, 1 fail, 1 were skipped", html)
        self.assertIn("No data", report_hard_cases.section(folder / "none"))

    def test_the_front_keeps_what_nothing_beats(self):
        points = [(1, 5), (2, 4), (2, 6), (3, 7), (0.5, 1)]
        self.assertEqual(report_figures.pareto(points, False), [(0.5, 1), (1, 5), (2, 6), (3, 7)])
        self.assertEqual(report_figures.pareto(points, True), [(0.5, 1)])


if __name__ == "__main__":
    unittest.main()
