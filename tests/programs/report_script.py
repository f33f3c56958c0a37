# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Tests scripts/report.py with a small record of cbvh_bench.

    report_script.py PATH/TO/cbvh_bench
"""

import contextlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import warnings
from html.parser import HTMLParser
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts/report.py"
BENCH = sys.argv.pop(1)
sys.path.insert(0, str(SCRIPT.parent))
import bench_records  # noqa: E402
import pandas  # noqa: E402
import report  # noqa: E402

from reporting import (  # noqa: E402
    checks, contents, errors, figures, formats, gpu, levels, memory, noise, pages, paper, relations, scale,
    summary, tradeoffs,
)  # fmt: skip
from reporting.data import KINDS, Data  # noqa: E402

SECTIONS = (
    "tradeoffs",
    "levels",
    "isas",
    "gpu",
    "errors",
    "relations",
    "figure10",
    "figure11",
    "pictures",
    "figure16",
    "figure17",
    "bins",
    "growth",
    "scale",
    "entrances",
    "robustness",
    "hard",
    "all",
    "run",
)

RAYS = [(ray_set, query) for ray_set in ("coherent", "incoherent") for query in ("closest", "any")]
GPU = "Device One, driver 1"


def gpu_record(record, mrays, device=GPU, bytes_per_quad=30000):
    """Returns a record as if a device had measured it. mrays: speed of each representation; bytes_per_quad: memory of
    cVOXEL, times TIMES for other kinds, a third of it on the device. Without a device, the record is one of the CPU."""
    record = json.loads(json.dumps(record))
    if device:
        record["run"]["settings"]["device"] = "vulkan"
    for group in record["groups"]:
        for result in group["results"]:
            third = bytes_per_quad // 3 * TIMES[result["kind"]] * group["quads"]
            held = {"device_bytes": third, "imported_bytes": 2 * third}
            if device:
                result["on_device"] = {"device": device, "upload_seconds": 0.1, **held}
            result["memory"]["live_bytes"] *= 3  # visible if other sections used it
            template = result["speed"][0]
            result["speed"] = []
            for ray_set, query in RAYS:
                summary = {"min": mrays[result["kind"]], "max": mrays[result["kind"]], "spread": 0.0}
                ratio = mrays[result["kind"]] / mrays["GRID"]
                result["speed"].append(
                    {
                        **template,
                        "ray_set": ray_set,
                        "query": query,
                        "mrays_per_second": {"median": mrays[result["kind"]], **summary},
                        "relative_to_grid": {"median": ratio, "min": ratio, "max": ratio, "spread": 0.0},
                    }
                )
    return record


TIMES = {"NAIVE": 16, "NAIVE-compact": 10, "GRID": 4, "cGRID": 3, "cVOXEL": 1, "cLEAF": 2, "cLEAF-only": 2}
ON_GPU = {"NAIVE": 400.0, "NAIVE-compact": 400.0, "GRID": 200.0, "cGRID": 100.0, "cVOXEL": 800.0, "cLEAF": 500.0}
ON_GPU["cLEAF-only"] = 300.0
ON_PROCESSOR = {kind: 2.0 for kind in ON_GPU}


def sections_of(html):
    """Returns the HTML of each section by its name."""
    parts = html.split('<section><h2 id="')[1:]
    return {part[: part.index('"')]: part[: part.index("</section>")] for part in parts}


class Page(HTMLParser):
    """Checks that tags nest correctly, and collects references and tables that are not in scrollable containers."""

    VOID = {"meta", "img", "br", "wbr"}

    def __init__(self, text):
        super().__init__()
        self.tables, self.bare = 0, 0
        self.open, self.ids, self.references, self.alternatives = [], [], [], 0
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.ids += [found["id"]] if "id" in found else []
        self.references += [found[name] for name in ("src", "srcset", "href") if name in found]
        if tag == "table":
            self.tables += 1
            self.bare += self.open[-1] != ("div", "table")
        self.alternatives += tag == "img" and bool(found.get("alt"))
        if tag not in self.VOID:
            self.open.append((tag, found.get("class")))

    def handle_endtag(self, tag):
        assert self.open and self.open.pop()[0] == tag, f"</{tag}> closes something else"


def cells(parts):
    """Returns all cells of the tables in the parts of a section, including folded ones."""
    found = []
    for part in parts:
        if isinstance(part, formats.Table):
            found += [cell for row in part.rows for cell in row]
        found += cells(part.parts) if isinstance(part, formats.Fold) else []
    return found


def texts(parts):
    return " ".join(part for part in parts if isinstance(part, str))


# Today's name of a member, and the one that earlier programs wrote.
FORMER_NAMES = """fallback_quads exact_quads, fallback_quads_share exact_quads_share, header_bytes frame_bytes,
uncompressed_bytes grid_bytes, uncompressed_quads grid_quads, hit_agreement hits_beside_first_library,
leaf_bytes_method leaf_bytes_are, max_border_mismatch max_border_gap, different_distance other_distance,
different_hit_or_miss other_hit_or_miss, different_ids other_ids, different_counts other_number,
different_parities other_parity, different_rays other_rays, different_uv_or_normal other_uv_or_normal,
inlier_rmse_pixels rmse_of_others_pixels, same_hit_errors same_place_errors, same_hit_rays same_place_rays,
ray_set set, flipped_errors turned_errors, flipped_rays turned_rays, uv_median_quads uv_median_cells,
uv_p99_quads uv_p99_cells"""


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
                "naive,naive-compact,cvoxel,cleaf,cleaf-only,cgrid^2",
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
        """Runs the script in this process, because its imports take 1.5 seconds. Returns its status and output."""
        out, errors = io.StringIO(), io.StringIO()
        with contextlib.ExitStack() as stack:
            stack.enter_context(contextlib.redirect_stdout(out))
            stack.enter_context(contextlib.redirect_stderr(errors))
            stack.enter_context(unittest.mock.patch.object(sys, "argv", [str(SCRIPT), *map(str, words)]))
            stack.enter_context(warnings.catch_warnings())
            warnings.simplefilter("default")  # as in a new process
            for ignored in DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning:
                warnings.simplefilter("ignore", ignored)
            try:
                status = report.main()
            except SystemExit as stopped:
                status = stopped.code if isinstance(stopped.code, int) else 1
                errors.write("" if isinstance(stopped.code, int) else f"{stopped.code}\n")
        return subprocess.CompletedProcess(words, status, out.getvalue(), errors.getvalue())

    def run_without_charts(self, *words):
        """Like run_script without drawing charts, which take most of the time and are tested once."""
        with unittest.mock.patch.object(figures, "chart", lambda text, *_: figures.Picture(text, "svg+xml", b"")):
            return self.run_script(*words)

    def run_process(self, *words):
        command = [sys.executable, "-B", str(SCRIPT), *map(str, words)]
        return subprocess.run(command, capture_output=True, text=True, timeout=200)

    def test_page_is_complete_and_self_contained(self):
        # A damaged record is reported in one line and left out.
        folder = Path(self.temporary.name) / "damaged"
        shutil.copytree(self.records, folder)
        text = (folder / "cube_L2-6.json").read_text()
        (folder / "short_L4.json").write_text(text[:1000])
        done = self.run_process(folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, r"\Areport\.py: warning: short_L4\.json: truncated.*\n\Z")

        html = (folder / "report.html").read_text()
        page = Page(html)
        self.assertEqual(page.open, [])
        self.assertEqual([name for name in page.ids if name in SECTIONS], list(SECTIONS))
        for reference in page.references:
            self.assertTrue(reference.startswith("data:") or reference[1:] in page.ids, reference[:60])
        self.assertGreater(page.alternatives, 10)
        self.assertIn("short_L4.json", html)
        self.assertIn("Leaks and self-shadowing", html)
        self.assertGreaterEqual(html.count("1e-4 diagonals"), 8 * 2)
        self.assertIn("No data", html, "the page reports missing scenes")
        self.assertIn("cbvh_bench --scene cube --level 2,6", html)
        self.assertNotIn(str(folder), html)
        bodies = sections_of(html)
        for section in SECTIONS[:-2]:
            self.assertTrue("Made by" in bodies[section] or "No data" in bodies[section], section)
            self.assertLessEqual(bodies[section].count("Made by"), 1, section)
        self.assertRegex(bodies["run"], r"Noise: .* spreads by [\d.]+% \(median of \d+ combinations")
        self.assertNotIn("-0.0000", html)
        self.assertGreater(page.tables, 10)
        self.assertEqual(page.bare, 0, "wide tables scroll inside of their containers")
        style = html[html.index("<style>") : html.index("</style>")]
        self.assertRegex(style, r"\.table \{[^}]*overflow-x: auto")
        self.assertRegex(style, r"figure img \{[^}]*width: 100%")
        self.assertIn('name="viewport"', html)
        tables = (folder / "tables.md").read_text()
        self.assertIn("| GRID |", tables)
        self.assertIn("| relation | paper | ours | verdict |", tables)

    def data(self, folder=None, **paths):
        return Data(folder or self.records, **paths)

    def results(self):
        return {r["representation"]: r for r in self.record()["groups"][1]["results"]}

    def test_first_screen_shows_the_result(self):
        done = self.run_without_charts(self.records, "--output", Path(self.temporary.name) / "first.html")
        self.assertEqual(done.returncode, 0, done.stderr)
        first = (Path(self.temporary.name) / "first.html").read_text().split("<nav")[0]
        self.assertEqual(first.count("<img"), 3, "memory, speed and error")
        ours, grid = self.results()["cLEAF^2"], self.results()["GRID"]
        smaller = grid["memory"]["live_bytes"] / ours["memory"]["live_bytes"]
        self.assertIn(f"{formats.ratio(smaller)} times smaller", first)
        self.assertIn(f"{ours['memory']['bytes_per_quad']:.2f} bytes per quad", first)
        for ray_set in ("coherent", "incoherent"):
            (speed,) = [s for s in ours["speed"] if (s["view"], s["ray_set"]) == ("full", ray_set)]
            self.assertIn(formats.ratio(speed["relative_to_grid"]["median"]), first)
            self.assertIn(f"{speed['mrays_per_second']['median']:.3g} million {ray_set} rays", first)
        errors_of_view = next(view for view in ours["views"] if view["view"] == "full")["errors"]
        self.assertIn(f"{pages.escape(formats.pixels(errors_of_view['p99_pixels']))} pixels of error", first)
        self.assertIn(f"median is {pages.escape(formats.pixels(errors_of_view['median_pixels']))} pixels", first)
        self.assertNotIn("RMSE", first)
        exact = ours["memory"]["compression"]["fallback_quads_share"]
        self.assertIn(f"cLEAF<sup>2</sup> stores {100 * exact:.1f}% of its quads as cVERT", first)

    def test_first_screen_covers_all_scenes(self):
        folder = Path(self.temporary.name) / "scenes"
        shutil.copytree(self.records, folder)
        for scene, factor in (("frog", 2), ("trex", 0.5)):
            record = self.record()
            for group in record["groups"]:
                group["scene"] = scene
                for result in group["results"]:
                    ours = result["representation"] == "cLEAF^2"
                    result["memory"]["live_bytes"] = int((1000 * factor if ours else 10000))
                    for speed in result["speed"]:
                        speed["relative_to_grid"]["median"] = 0.25 * factor if speed["view"] == "close" else 1.5
                    for view in result["views"]:
                        view["errors"]["p99_pixels"] = 0.25 * factor
            (folder / f"{scene}_L2-6.json").write_text(json.dumps(record))
        (folder / "cube_L2-6.json").unlink()
        data = self.data(folder)
        first = summary.first_screen(data)
        self.assertEqual((first["row"].scene, first["row"].level, first["row"]["view"]), ("trex", 6, "full"))
        ranges = [over for *_, over in first["statements"]]
        self.assertEqual(
            ranges, ["5.00 to 20.0 times smaller", "0.12 to 1.50 times GRID's speed", "0.1250 to 0.5000 pixels"]
        )
        rows = first["places"].rows
        self.assertIn(["frog", "6", "full", "5.00", "1.50", "1.50", "0.5000"], rows)
        self.assertIn(["trex", "6", "close", "20.0", "0.12", "0.12", "0.1250"], rows)
        self.assertEqual(len(rows), 2 * 2 * 2, "scenes, levels and views")
        self.assertEqual(self.run_script(folder).returncode, 0)
        for page in ("report.html", "tables.md"):
            text = (folder / page).read_text().replace("&#39;", "'")
            for over in ranges:
                self.assertIn(over, text)

    def test_errors_are_medians_and_p99_except_for_the_papers(self):
        output = Path(self.temporary.name) / "errors.html"
        done = self.run_without_charts(self.records, "--output", output)
        self.assertEqual(done.returncode, 0, done.stderr)
        bodies = sections_of(output.read_text())
        for name in ("tradeoffs", "errors", "gpu", "levels", "growth"):
            self.assertNotIn("RMSE", bodies[name], name)
        self.assertIn("p99", bodies["errors"])
        self.assertIn("RMSE", bodies["relations"])
        heads = [
            line
            for line in output.with_name("tables.md").read_text().split("\n")
            if "RMSE" in line and line.startswith("| level")
        ]
        self.assertTrue(heads and all(line.count("RMSE") == line.count("the paper's RMSE") for line in heads), heads)
        shown = cells(errors.section(self.data())[0])
        for view in self.results()["cLEAF^2"]["views"]:
            for kind in ("errors", "errors_to_true_surface"):
                for key in ("median_pixels", "p99_pixels"):
                    self.assertIn(formats.pixels(view[kind][key]), shown)

    def test_share_of_fallback_quads_is_next_to_memory_of_cleaf(self):
        results = {r["representation"]: r for r in self.record()["groups"][1]["results"]}
        exact, only = (results[label]["memory"]["compression"] for label in ("cLEAF^2", "cLEAF-only^2"))
        self.assertEqual(only["fallback_quads"], 0)
        self.assertGreater(exact["fallback_quads"], 0)
        percent = f"{100 * exact['fallback_quads'] / exact['quads']:.1f}"
        self.assertAlmostEqual(exact["fallback_quads_share"], exact["fallback_quads"] / exact["quads"])
        parts, _ = levels.section(self.data())
        (table,) = [part for part in parts if part.title == f"cube: {levels.FALLBACK}"]
        self.assertIn(("cLEAF^2", percent + "%"), [(row[0], row[2]) for row in table.rows])
        self.assertEqual({row[0] for row in table.rows}, {"cLEAF^2", "cLEAF^3"}, "only cLEAF has faces of two forms")
        self.assertEqual(self.run_without_charts(self.records).returncode, 0)
        lines = (self.records / "tables.md").read_text().split("\n")
        lines = [line.split(" | ") for line in lines if line.startswith("| 6 | cLEAF")]
        self.assertIn(
            (percent + "%", "-"),
            [(a[4], b[4]) for a in lines for b in lines if (a[1], b[1]) == ("cLEAF^2", "cLEAF-only^2")],
        )

    def test_leaves_only_of_old_records_is_renamed(self):
        folder = Path(self.temporary.name) / "old"
        folder.mkdir()
        record = self.record()
        record["run"]["settings"]["leaves_only"] = True
        for group in record["groups"]:
            group["results"] = [r for r in group["results"] if r["kind"] != "cLEAF-only"]
        (folder / "cube_L2-6.json").write_text(json.dumps(record))
        found = {
            (r["representation"], r["kind"])
            for r in bench_records.read(folder / "cube_L2-6.json")["groups"][0]["results"]
        }
        self.assertIn(("cLEAF-only^2", "cLEAF-only"), found)
        self.assertNotIn("cLEAF", {kind for _, kind in found})

    def test_former_names_of_members_are_read(self):
        folder = Path(self.temporary.name) / "former"
        folder.mkdir()
        former = dict(pair.split() for pair in FORMER_NAMES.split(","))
        self.assertEqual(set(former.values()), set(bench_records.NEW_NAMES))
        self.assertEqual(len(former), len(bench_records.NEW_NAMES))
        record = self.record()
        for result in (result for group in record["groups"] for result in group["results"]):
            result["members"] = dict.fromkeys(former, 1)  # also of members that this record lacks
        text = json.dumps(record)
        for new, old in former.items():
            self.assertIn(f'"{new}": ', text)
            text = text.replace(f'"{new}": ', f'"{old}": ')
        (folder / "cube_L2-6.json").write_text(text)
        self.assertEqual(bench_records.read(folder / "cube_L2-6.json"), record)

    def test_rates_of_shadow_errors_are_per_ray_of_their_subset(self):
        errors, none = {"false_occlusions": 3, "false_passes": 1}, {"false_occlusions": 0, "false_passes": 0}
        shadow = {"view": "full", "offset": "1 pixels", "length": None, "rays": 1000, "occluded": 9, "errors": errors,
                  "same_hit_rays": 500, "same_hit_errors": errors, "flipped_rays": 16, "flipped_errors": errors,
                  "control_errors": none}  # fmt: skip
        record = self.record()
        for group in record["groups"]:
            for result in group["results"]:
                result["shadows"] = [shadow]
        folder = Path(self.temporary.name) / "shadows"
        folder.mkdir()
        (folder / "cube_L2-6.json").write_text(json.dumps(record))
        (table,) = [part for part in checks.section(self.data(folder))[0] if part.title.startswith("Shadows")]
        rates = {head: row for head, row in zip(table.heads, table.rows[0])}
        self.assertEqual(
            {head: rates[head] for head in (*checks.ERROR_RATES, "rays flipped")},
            {
                "wrong": "4.000",
                "dark": "3.000",
                "bright": "1.000",
                "same hit": "8.000",
                "flipped": "250.000",
                "control": "0.000",
                "rays flipped": "16.000",
            },
        )

    def test_dark_pages_invert_charts(self):
        chart = figures.chart("x", 3, lambda axes: axes.set_title("x"))
        self.assertIn(figures.INK.encode(), chart.content)
        self.assertIn(b"fill: none", chart.content.split(b"</defs>")[0] + b"fill: none", "no background")
        page = pages.render("page.html", sections=[], first={}, subject="", csv="")
        self.assertRegex(page, r"prefers-color-scheme: dark[^@]*img\.chart \{ filter: invert\(1\)")

    def test_parts_of_memory_add_up(self):
        for _, row in self.data().full.iterrows():
            parts = memory.parts(row)
            self.assertEqual(sum(parts.values()), row.memory_live_bytes, row.representation)
            self.assertGreaterEqual(min(parts.values()), 0, row.representation)

    def test_compact_mode_stands_next_to_naive(self):
        data, both = self.data(self.folder_of("compact", trex=self.record())), ["NAIVE", "NAIVE-compact"]
        naive, compact = (data.pick("trex", 6, label) for label in both)
        self.assertLess(compact.memory_live_bytes, 0.8 * naive.memory_live_bytes)
        drawn = {}
        keep = lambda text, height, draw, *rest: drawn.update({text: rest}) or figures.Picture(text, "svg+xml", b"")
        with unittest.mock.patch.object(figures, "chart", keep):
            memory.section(data)
            bars, table = paper.figure_16(data)[0]
            levels.growth(data)
            tradeoffs.section(data)
        (rows, *_) = drawn["Memory, Level 6"]
        self.assertEqual([row.representation for row in rows][:3], [*both, "GRID"])
        self.assertEqual([row[0] for row in table.rows][:2], both)
        self.assertLessEqual(set(both), set(drawn["Speed, coherent rays"][1].representation))
        self.assertLessEqual(set(both), set(drawn["Memory over the number of quads"][-1].representation))
        for table in levels.section(data)[0]:
            if table.title != f"trex: {levels.FALLBACK}":
                self.assertEqual([row[0] for row in table.rows][:3], [*both, "GRID"], table.title)
        fronts = [rest[0] for text, rest in drawn.items() if "against error" in text]
        self.assertTrue(fronts)
        for frame in fronts:
            self.assertFalse(set(both) & set(frame.kind), "GRID's triangles have no error of their own")

    def test_numbers_and_axes_are_readable(self):
        self.assertEqual(formats.signed(-0.00001), "0.0000")
        self.assertEqual(formats.signed(-0.0002), "-0.0002")
        for low, high in ((0.9, 1.2), (3, 40), (0.5, 9), (1e-3, 1e4), (2e-5, 3e-5), (1, 1e12)):
            ticks = figures.log_ticks(low, high)
            self.assertTrue(3 <= len(ticks) <= 7, (low, high, ticks))
            self.assertTrue(all(0.999 * low <= tick <= 1.001 * high for tick in ticks))

    def test_instruction_sets_of_other_machines_are_added(self):
        folder = Path(self.temporary.name) / "another"
        folder.mkdir()
        record = self.record()
        record["run"].update(cpu="Processor elsewhere", commit="c0ffee")
        for group in record["groups"]:
            for result in group["results"]:
                result["isa"] = "avx512"
        (folder / "cube_L2-6.json").write_text(json.dumps(record))
        before = self.data()
        self.assertEqual(levels.by_instruction_set(before), {})
        data = self.data(other_machines=[folder])
        self.assertEqual((data.isa, len(data.here)), (before.isa, len(before.here)), "other sections must not show it")
        parts, _ = levels.isas(data)
        (table,) = [
            part for part in parts if isinstance(part, formats.Table) and part.title == "cube, level 6, coherent"
        ]
        self.assertEqual(
            table.heads[-2:], ["avx512, Processor elsewhere: Mrays/s", "avx512, Processor elsewhere: of GRID"]
        )
        self.assertEqual({len(row) for row in table.rows}, {1 + 2 * 2})
        self.assertNotIn("-", [cell for row in table.rows for cell in row])
        output = Path(self.temporary.name) / "other_machine.html"
        done = self.run_script(self.records, "--output", output, "--other-machine", folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("Processor elsewhere", sections_of(output.read_text())["isas"])
        self.assertIn("Processor elsewhere", output.with_name("tables.md").read_text())
        none = self.run_script(self.records, "--output", output, "--other-machine", folder / "none")
        self.assertEqual((none.returncode, none.stderr.count("\n")), (1, 1))

    def test_markdown_contains_the_measurements(self):
        folder = self.gpu_folder("markdown", {})
        record = self.record()
        for group in record["groups"]:
            results = group["results"]
            group["results"] = [{**r, "isa": isa} for isa in ("sse4.2", "avx", results[0]["isa"]) for r in results]
        (folder / "isas_L2-6.json").write_text(json.dumps(record))
        self.assertEqual(self.run_script(folder).returncode, 0)
        text = (folder / "tables.md").read_text()
        heads = [line for line in text.split("\n") if line.startswith("#")]
        for head in ("## cube", "### cube: error", "### cube, level 6, incoherent", "### cube: bytes per quad"):
            self.assertIn(head, heads)
        width = 0
        for line in text.split("\n"):
            if line.startswith("|"):
                width = width or line.count("|")
                self.assertEqual(line.count("|"), width, line)
            else:
                width = 0
        data = self.data(folder)
        (rows,) = [rows for (_, level), rows in levels.by_instruction_set(data).items() if level == 6]
        self.assertLessEqual({"sse4.2", "avx"}, set(rows.isa))
        (table,) = [part for part in levels.section(data)[0] if part.title == "cube: bytes per quad"]
        self.assertEqual(table.heads, ["", "level 2", "level 6"])
        six = f"{self.results()['cLEAF^3']['memory']['bytes_per_quad']:.2f}"
        self.assertIn(["cLEAF^3", six], [[row[0], row[2]] for row in table.rows])
        self.assertIn(f" | {six} | ", text)

    def test_csv_contains_every_measurement(self):
        self.assertEqual(self.run_without_charts(self.records, "--csv", self.records / "all.csv").returncode, 0)
        table = pandas.read_csv(self.records / "all.csv")
        speeds = [
            speed for group in self.record()["groups"] for result in group["results"] for speed in result["speed"]
        ]
        self.assertEqual((table.what == "speed").sum(), len(speeds))
        ours = table[(table.representation == "cLEAF^2") & (table.level == 6)]
        ours = ours[(ours["view"] == "full") & (ours.ray_set == "coherent")]
        (speed,) = [s for s in self.results()["cLEAF^2"]["speed"] if (s["view"], s["ray_set"]) == ("full", "coherent")]
        (view,) = [view for view in self.results()["cLEAF^2"]["views"] if view["view"] == "full"]
        self.assertAlmostEqual(ours.mrays_per_second_median.item(), speed["mrays_per_second"]["median"])
        self.assertAlmostEqual(ours.errors_p99_pixels.item(), view["errors"]["p99_pixels"])
        self.assertEqual(ours.memory_live_bytes.item(), self.results()["cLEAF^2"]["memory"]["live_bytes"])
        shadows = [
            shadow
            for group in self.record()["groups"]
            for result in group["results"]
            for shadow in result.get("shadows", [])
        ]
        self.assertEqual(len(table[table.what == "shadow"]), len(shadows))
        self.assertTrue(len(shadows) and table.leaks_rays.notna().any())
        self.assertNotIn(str(self.records), (self.records / "all.csv").read_text())

    def test_example_of_the_documentation_runs(self):
        page = (SCRIPT.parents[1] / "docs/paper.md").read_text()
        (code,) = re.findall(r"^    import pandas\n(?:    .*\n)+", page, re.MULTILINE)
        self.assertLessEqual(code.count("\n"), 4)
        self.assertEqual(self.run_without_charts(self.records).returncode, 0)
        code = re.sub(r"^    ", "", code, flags=re.MULTILINE).replace(
            "output/benchmark/paper/records.csv", str(self.records / "records.csv")
        )
        found = {}
        exec(code, found)
        self.assertGreater(len(found["table"]), 5)

    def test_scale_is_shown_if_measured(self):
        speed = {
            ray_set: {"closest": {"mrays_per_second": rays}}
            for ray_set, rays in (("coherent", 1.5), ("incoherent", 0.75))
        }
        opened = {"open_seconds": 0.25, "picture_seconds": 40, "quads": 2 * 10**9, "speed": speed}
        herd = {
            "count": 62, "level": "6", "quads": 2 * 10**9, "file_bytes": 5 * 2**30,
            "resumed_geometries": 41, "last_quads": 6 * 10**8, "last_seconds": 30,
            "stops": [{"seconds": 40, "bytes": 2**30, "signal": "SIGINT"},
                      {"seconds": 20, "bytes": 3 * 2**30, "signal": "SIGKILL"}],
            "build_seconds": 90, "anonymous_bytes": 2**27, "cold": opened, "warm": opened,
            "cold_mapped_bytes": 2**30, "render_anonymous_bytes": 2**28,
            "size": "64x48", "samples": 4, "picture": "none.png", "threads": 2, "memory": 2**34,
            "commands": ["render the herd"],
            "device_bytes": 2**26, "from_file": {"count": 2, "quads": 10**8, "bytes": 2**24, "file_bytes": 2**28,
                                                 "speed": speed, "command": "render some"},
            "in_memory": [{"count": 2, "representation": "GRID", "quads": 10**8, "bytes": 4 * 10**9,
                           "peak_bytes": 5 * 10**9, "build_seconds": 9, "speed": speed, "command": "render GRID"}],
        }  # fmt: skip
        level = {"scene": "trex", "view": "full", "level": "auto", "quads": 10**6, "live_bytes": 2**22,
                 "build_seconds": 0.5, "speed": speed, "size": "64x48", "command": "render levels",
                 "errors_to_true_surface": {"median_pixels": 0.125, "p99_pixels": 0.5}}  # fmt: skip
        folder = Path(self.temporary.name) / "scale"
        folder.mkdir()
        (folder / scale.RECORD).write_text(json.dumps({"date": "2026-01-01", "herd": herd, "levels": [level]}))
        text = "\n".join(
            part if isinstance(part, str) else part.markdown() for part in scale.tables(scale.read(folder))
        )
        for found in ("20.0 million quads per second", "74.5 GiB, computed from 40.0 bytes per quad",
                      "interrupted at 1.0 GiB and killed at 3.0 GiB",
                      "0.34 billion", "| trex, full | auto | 1.00 | 4.0 |"):  # fmt: skip
            self.assertIn(found, text)
        page = Path(self.temporary.name) / "scale.html"
        self.assertEqual(self.run_without_charts(self.records, "--scale", folder, "--output", page).returncode, 0)
        for found in ("computed from 40.0 bytes per quad", "Levels by the view", "render GRID"):
            self.assertIn(found, page.read_text())
        done = self.run_script(self.records, "--scale", self.records, "--output", page)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
        self.assertRegex(done.stderr, f"{self.records}: .*measure_scale.py")

    def test_former_names_of_the_scale_are_read(self):
        old = {"date": "2026-01-01", "herd": {"fileBytes": 1, "ownBytes": 2, "coldMapped": 3, "some": {"fileBytes": 4},
                                              "cold": {"openProcessorSeconds": 5}, "beside": [{"peak": 6}],
                                              "renderOwnBytes": 7, "found": 8}}  # fmt: skip
        new = {"date": "2026-01-01", "herd": {"file_bytes": 1, "anonymous_bytes": 2, "cold_mapped_bytes": 3,
                                              "from_file": {"file_bytes": 4}, "cold": {"open_processor_seconds": 5},
                                              "in_memory": [{"peak_bytes": 6}], "render_anonymous_bytes": 7,
                                              "resumed_geometries": 8}}  # fmt: skip
        folder = Path(self.temporary.name) / "former scale"
        folder.mkdir()
        for record in (old, new):
            (folder / scale.RECORD).write_text(json.dumps(record))
            self.assertEqual(scale.read(folder), new)

    def folder_of(self, name, **records):
        """Returns a new folder with the records, each as if it were measured for another scene."""
        folder = Path(self.temporary.name) / name
        folder.mkdir()
        for scene, record in records.items():
            for group in record["groups"]:
                group["scene"] = scene
            (folder / f"{scene}_L2-6.json").write_text(json.dumps(record))
        return folder

    def test_what_was_not_measured_has_no_verdict(self):
        """The job cube_fivefold alone measures none of what the paper states about its T-rex."""
        folder = self.folder_of("part", **{"cube:0.45": self.record()})
        shutil.copytree(self.records / "pictures", folder / "pictures")
        done = self.run_without_charts(folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        table, _ = relations.section(self.data(folder))
        self.assertGreater(len(table[0].rows), 10)
        for claim, _, ours, says in table[0].rows:
            self.assertNotIn("cube:0.45", claim)
            self.assertEqual((ours, says), ("not measured", "not measured"), claim)
        html = (folder / "report.html").read_text()
        bodies = sections_of(html)
        for name in ("figure11", "figure16", "figure17"):
            self.assertIn("No data", bodies[name])
            self.assertIn("trex", bodies[name])
            self.assertNotIn("cube:0.45", bodies[name])
        self.assertIn("Figure 12: trex", bodies["pictures"])
        self.assertNotIn("Figure 12: cube", bodies["pictures"])
        self.assertIn("Figure 18, five-fold displacement: cube:0.45", bodies["pictures"])
        self.assertIn("Not measured: trex, cube, frog, scythe, knee", html.split("<nav")[0])
        self.assertIn("cube:0.45 at level 6", html.split("<nav")[0], "the first screen names its scene")

    def test_means_over_levels_need_all_levels(self):
        """A relation over levels 4 to 6, both ray sets."""
        claims = "speed of cVOXEL|speed of cLEAF-only|is slower than"

        def judged(levels, change=lambda result: None):
            record = self.record()
            group = next(group for group in record["groups"] if group["level"] == 6)
            for result in group["results"]:
                change(result)
            fine = [r for r in group["results"] if r["representation"] == "cVOXEL^2"]
            group["results"] += [{**r, "representation": "cVOXEL^4", "frame_level": 4} for r in fine]
            record["groups"] = [{**group, "level": level} for level in levels]
            folder = self.folder_of(f"levels {levels} {change.__name__}", trex=record)
            return [r.holds is not None for r in relations.relations(self.data(folder)) if re.search(claims, r.claim)]

        def without_incoherent(result):
            result["speed"] = [speed for speed in result["speed"] if speed["ray_set"] != "incoherent"]

        self.assertEqual(judged([4, 5, 6]), [True] * 3)
        for levels in ([6], [4, 6], [5, 6, 7]):
            self.assertFalse(any(judged(levels)), levels)
        self.assertFalse(any(judged([4, 5, 6], without_incoherent)))

    def test_own_cage_is_not_compared_with_the_papers_scenes(self):
        """Also if its name is the name of one of them."""
        for name in ("cube", "trex"):
            record = self.record()
            record["run"]["command"] = record["run"]["command"].replace("--scene cube", f"--cage {name}.obj")
            data = self.data(self.folder_of(f"own {name}", **{name: record}))
            self.assertTrue(data.is_own())
            self.assertEqual(relations.section(data), ([], []))
            self.assertEqual(paper.figure_10(data), ([], []))
            with unittest.mock.patch.object(figures, "chart", lambda *_: figures.Picture("", "svg+xml", b"")):
                heads = paper.figure_16(data)[0][1].heads
            self.assertEqual([head for head in heads if "paper" in head and "T-rex" not in head], [])

    def own_records(self, name):
        """Returns the records as if they were measured for a user's cage."""
        folder = Path(self.temporary.name) / name
        shutil.copytree(self.records, folder)
        record = self.record()
        record["run"]["command"] = record["run"]["command"].replace("--scene cube", "--cage sofa.obj")
        for group in record["groups"]:
            group["scene"] = "sofa"
        (folder / "cube_L2-6.json").write_text(json.dumps(record))
        (folder / "cube_L2-6.json").rename(folder / "sofa_L2-6.json")
        (folder / "pictures/cube").rename(folder / "pictures/sofa")
        return folder

    def test_own_cage_has_no_empty_sections(self):
        folder = self.own_records("own")
        done = self.run_script(folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        html = (folder / "report.html").read_text()
        self.assertEqual(re.findall("No data: [^<]*", html), [])
        page = Page(html)
        for reference in page.references:
            self.assertTrue(reference.startswith("data:") or reference[1:] in page.ids, reference[:60])
        shown = [name for name in page.ids if name in SECTIONS]
        for name in ("tradeoffs", "levels", "errors", "figure16", "figure17", "growth", "robustness", "all", "run"):
            self.assertIn(name, shown)
        for name in ("figure10", "scale", "isas", "gpu"):
            self.assertNotIn(name, shown)
        for other in ("frog", "scythe", "knee", "trex"):
            self.assertNotIn(f": {other}<", html)
        self.assertNotIn("not measured |", (folder / "tables.md").read_text())

    def test_period_has_a_start_and_an_end(self):
        run = self.record()["run"]
        self.assertGreater(run["end"], run["date"])
        self.assertEqual(noise.period([run]), f"{run['date']} to {run['end']}")
        older, later = {"date": "2026-01-02T00:00:00Z"}, {"date": "2026-01-01T00:00:00Z", "end": "2026-01-03T00:00:00Z"}
        self.assertEqual(noise.period([older]), older["date"])
        self.assertEqual(noise.period([older, later]), f"{later['date']} to {later['end']}")
        page = Path(self.temporary.name) / "period.html"
        self.assertEqual(self.run_without_charts(self.records, "--output", page).returncode, 0)
        for text in (page.read_text(), page.with_name("tables.md").read_text()):
            self.assertIn(f"{run['date']} to {run['end']}", text)

    def test_missing_package_is_reported_in_one_line(self):
        for module in ("matplotlib", "pandas", "jinja2"):
            without = Path(self.temporary.name) / f"no_{module}"
            (without / module).mkdir(parents=True)
            (without / f"{module}/__init__.py").write_text(f"raise ModuleNotFoundError(name={module!r})\n")
            environment = {**os.environ, "PYTHONPATH": str(without)}
            names = ["report.py", "claims.py"] + ["measure_blender.py"] * (module == "matplotlib")
            for script in map(SCRIPT.with_name, names):
                command = [sys.executable, "-B", str(script), str(self.records)]
                done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment)
                self.assertEqual(done.returncode, 1)
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
                self.assertIn(f"python3-{module}", done.stderr)

    def test_missing_program_or_record_is_reported_without_a_traceback(self):
        missing = str(Path(self.temporary.name) / "missing")
        for words in (
            ["claims.py", "--render", missing],
            ["measure_files.py", missing, self.temporary.name],
            ["measure_meshes.py", missing, self.temporary.name],
            ["measure_scale.py", missing, self.temporary.name],
            ["performance.py", "--bench", missing],
            ["performance.py", "--record", missing],
        ):
            command = [sys.executable, "-B", str(SCRIPT.with_name(words[0])), *words[1:]]
            done = subprocess.run(command, capture_output=True, text=True, timeout=60)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(missing, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_output_follows_links_and_devices_and_never_replaces_records(self):
        folder = Path(self.temporary.name) / "outputs"
        shutil.copytree(self.records, folder)
        before = {path: path.read_bytes() for path in folder.glob("*.json")}
        names = {path.name for path in folder.iterdir()} | {"pictures", "store", "link.html", "null", "records.csv"}
        (folder / "store").mkdir()
        (folder / "link.html").symlink_to("store/page.html")
        (folder / "null").symlink_to("/dev/null")
        done = self.run_without_charts(folder, "--output", folder / "link.html", "--tables", folder / "null")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((folder / "link.html").is_symlink() and (folder / "null").is_symlink())
        self.assertIn("<h1>", (folder / "store/page.html").read_text())
        self.assertEqual({path.name for path in folder.iterdir()}, names, "a temporary file was left")
        (folder / "store/page.html").chmod(0o604)
        done = self.run_process(folder, "--output", folder / "link.html", "--tables", "/dev/stdout")
        self.assertIn("| relation | paper |", done.stdout)
        self.assertEqual((folder / "store/page.html").stat().st_mode & 0o7777, 0o604)
        (folder / "same.html").symlink_to("cube_L2-6.json")
        for words in (
            ["--output", folder / "cube_L2-6.json"],
            ["--tables", folder / "same.html"],
            ["--csv", folder / "cube_L2-6.json"],
            ["--against", self.records, "--output", self.records / "cube_L2-6.json"],
        ):
            done = self.run_script(folder, *words)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
            self.assertRegex(done.stderr, rf"{words[-1]}: .*record cube_L2-6\.json")
        done = self.run_script(folder, "--output", folder / "one", "--tables", folder / "./one")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
        self.assertRegex(done.stderr, f"{folder}/one: .*--output.*--tables")
        self.assertEqual(before, {path: path.read_bytes() for path in before})

    def test_invalid_folders_are_reported_in_one_line(self):
        empty = Path(self.temporary.name) / "empty"
        empty.mkdir()
        for folder in (empty, empty / "none"):
            done = self.run_script(folder)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertRegex(done.stderr, f"{folder}: .*benchmark.py")

    def test_run_does_not_differ_from_itself(self):
        data = self.data()
        apart = noise.compare_runs(data.here, self.data().here)
        self.assertGreater(len(apart), 10)
        self.assertEqual((apart.max(), (apart > 0.05).sum()), (0, 0))
        parts, _ = noise.section(data, self.data(), "here")
        self.assertRegex(texts(parts), f"Two runs: .* {len(apart)} combinations differ by 0.0% .*: 0 by more than 5%")

    def test_errors_against_a_finer_mesh_use_the_job_that_has_them(self):
        folder = Path(self.temporary.name) / "finer"
        shutil.copytree(self.records, folder)
        points, finer = tradeoffs.points(self.data(folder), "cube", "coherent")
        self.assertFalse(finer)
        self.assertEqual(set(points.level), {6})
        record = json.loads((folder / "cube_L2-6.json").read_text())
        for group in record["groups"]:
            for result in group["results"]:
                for view in result["views"]:
                    view["errors_to_reference_level"] = view["errors"]
        (folder / "levels_L2-6.json").write_text(json.dumps(record))
        points, finer = tradeoffs.points(self.data(folder), "cube", "coherent")
        self.assertTrue(finer)
        self.assertEqual(set(zip(points.level, points.job)), {(2, "levels"), (6, "levels")})

    def test_more_rounds_reduce_the_uncertainty_of_medians(self):
        self.assertAlmostEqual(noise.uncertainty(0.027, 4), 0.025)
        self.assertAlmostEqual(noise.uncertainty(0.027, 16), 0.0125)

    def test_relations_are_judged_by_numbers(self):
        folder = Path(self.temporary.name) / "judged"
        folder.mkdir()
        record = json.loads((self.records / "cube_L2-6.json").read_text())
        for name, part, holds in (("small", 0.31, True), ("large", 0.32, False)):
            results = next(group for group in record["groups"] if group["level"] == 6)["results"]
            grid = next(r for r in results if r["representation"] == "GRID")["memory"]["live_bytes"]
            next(r for r in results if r["representation"] == "cLEAF-only^2")["memory"]["live_bytes"] = int(part * grid)
            (folder / "cube_L6.json").write_text(json.dumps(record))
            table = {r.claim: r for r in relations.relations(self.data(folder))}
            claim = "cube: memory of cLEAF-only^2 at level 6 as a part of GRID at level 6"
            self.assertEqual(table[claim].holds, holds, name)
            says = "holds" if holds else "does not hold: the reason is not known"
            self.assertEqual(relations.verdict(table[claim]), says)
            self.assertIn(f"{100 * part:.1f}%", table[claim].ours)
            missing = next(r for r in table.values() if re.search("frog|level 8", r.claim))
            self.assertIsNone(missing.holds, "a missing measurement has no verdict")

    def test_hard_cases_show_sentences_and_results_of_tests(self):
        folder = Path(self.temporary.name) / "hard_cases"
        folder.mkdir()
        for isa, result in (("sse2", ""), ("avx2", '<failure message="t is &lt; 0"/>'), ("avx512", "<skipped/>")):
            (folder / f"{isa}.xml").write_text(
                f'<testsuites><testsuite><testcase name="AlongAxes/cLEAF_{isa}" classname="HardCases/HardRays">{result}'
                '<properties><property name="property" value="rays &gt; boxes"/></properties>'
                "</testcase></testsuite></testsuites>"
            )
        (folder / "stopped.xml").write_text("<testsuites><testsuite>")
        ((case, results),) = checks.read_tests(folder).items()
        self.assertEqual(case, ("HardRays.AlongAxes", "rays > boxes"))
        self.assertEqual([results["cLEAF", isa] for isa in ("sse2", "avx2", "avx512")], ["passed", "failed", "skipped"])
        parts, _ = checks.hard_cases(folder)
        self.assertIn("fails: avx2", cells(parts))
        self.assertIn("3 tests on avx2, avx512, sse2: 1 passed, 1 failed, 1 skipped", texts(parts))
        section = contents.Section("hard", "More", "Hard cases", "", "", parts)
        self.assertIn("rays &gt; boxes", pages.render("page.html", sections=[section], first={}, subject="", csv=""))
        self.assertEqual(checks.hard_cases(folder / "none")[0], [])

    def gpu_folder(self, name, files):
        """Records of the CPU, and additional ones. files: names and records."""
        folder = Path(self.temporary.name) / name
        shutil.copytree(self.records, folder)
        for file, record in files.items():
            (folder / file).write_text(json.dumps(record))
        return folder

    def record(self):
        return json.loads((self.records / "cube_L2-6.json").read_text())

    def test_gpu_measurements_are_only_in_their_section(self):
        of_gpu, beside = gpu_record(self.record(), ON_GPU), gpu_record(self.record(), ON_PROCESSOR, None)
        bare = gpu_record(self.record(), ON_GPU)
        for result in bare["groups"][0]["results"]:
            del result["on_device"]  # only the settings of the run name the device
        files = {"other_L2-6.json": of_gpu, "gpu_cube_cpu_L2-6.json": beside, "bare_L2-6.json": bare}
        found, tables = [], []
        for folder in (self.gpu_folder("without", {}), self.gpu_folder("with", files)):
            done = self.run_script(folder)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            found.append(sections_of((folder / "report.html").read_text()))
            tables.append((folder / "tables.md").read_text())
        self.assertEqual(list(found[0]), list(SECTIONS))
        self.assertEqual([name for name in SECTIONS if found[0][name] != found[1][name]], ["gpu", "run"])
        self.assertIn("1 in without", found[0]["run"])
        self.assertIn("4 in with", found[1]["run"])
        self.assertIn("No data", found[0]["gpu"])
        self.assertIn(GPU, found[1]["gpu"])
        self.assertIn("Made by", found[1]["gpu"])
        self.assertGreaterEqual(found[1]["gpu"].count("<img"), 3)
        parts = [dict(part.partition("\n")[::2] for part in text.split("\n## ")) for text in tables]
        differing = {name for name in parts[1] if parts[0].get(name) != parts[1][name]}
        self.assertEqual(differing - {"Commands"}, {"GPU: speed against memory", "The run, and its noise"})
        self.assertIn(GPU, tables[1])

    def test_gpu_ratios_refer_to_grid_naive_and_cpu_of_the_same_picture(self):
        folder = Path(self.temporary.name) / "ratios"
        folder.mkdir()
        (folder / "gpu_cube_L2-6.json").write_text(json.dumps(gpu_record(self.record(), ON_GPU)))
        beside = gpu_record(self.record(), ON_PROCESSOR, None)
        changes = (
            (lambda run: None, 250.0),
            (lambda run: run["settings"].update(width=99), None),
            (lambda run: run.update(cpu="another"), None),
        )
        for change, ratio in changes:
            other = json.loads(json.dumps(beside))
            change(other["run"])
            (folder / "gpu_cube_cpu_L2-6.json").write_text(json.dumps(other))
            data = self.data(folder)
            rows = gpu.device_views(data)
            rows = rows[(rows.device == GPU) & (rows["view"] == "full") & (rows.level == 6)]
            self.assertEqual(set(rows.scene), {"cube"})
            (row,) = [row for _, row in rows.iterrows() if row.representation == "cLEAF^2"]
            self.assertEqual(row.incoherent_any, 500)
            self.assertEqual(row.incoherent_any_of_grid, 2.5)
            self.assertEqual(row.incoherent_any_of_naive, 1.25)
            self.assertEqual(row.incoherent_any_of_cpu if formats.is_known(row.incoherent_any_of_cpu) else None, ratio)
            self.assertEqual(row.held_per_quad, 60000)
            words = texts(gpu.section(data)[0])
            self.assertIn("cVOXEL^3 with 30000 bytes per quad, 25% of GRID, at 4.00 (coherent)", words)
            self.assertIn("fastest with coherent rays: cVOXEL^2 (4.00 times GRID)", words)
            self.assertEqual("50.0 to 400 times the speed of one thread" in words, ratio is not None)

    def test_memory_of_partly_filled_buffers_is_not_attributed(self):
        folder = Path(self.temporary.name) / "small"
        folder.mkdir()
        (folder / "small.json").write_text(json.dumps(gpu_record(self.record(), ON_GPU, bytes_per_quad=3)))
        parts, _ = gpu.section(self.data(folder))
        self.assertIn("does not distinguish representations", texts(parts))
        self.assertNotIn("smallest", texts(parts))
        self.assertEqual([part for part in parts if isinstance(part, list) and part], [], "no charts")

    def test_records_of_another_gpu_are_added(self):
        elsewhere = Path(self.temporary.name) / "elsewhere"
        elsewhere.mkdir()
        record = gpu_record(self.record(), ON_GPU)
        record["run"].update(cpu="Processor elsewhere", commit="c0ffee")
        (elsewhere / "trex_6.json").write_text(json.dumps(record))
        output = Path(self.temporary.name) / "elsewhere.html"
        before = self.run_script(self.records, "--output", output)
        self.assertEqual(before.returncode, 0, before.stderr)
        plain = output.read_text()
        for path in (elsewhere, elsewhere / "trex_6.json"):
            done = self.run_script(self.records, "--output", output, "--gpu", path)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            html = output.read_text()
            page = Page(html)
            self.assertEqual(page.open, [])
            self.assertIn(GPU, html)
            self.assertIn("Processor elsewhere", sections_of(html)["gpu"])
            self.assertEqual(html.split("<nav")[0], plain.split("<nav")[0], "the part about this machine is unchanged")
        none = self.run_script(self.records, "--output", output, "--gpu", elsewhere / "none.json")
        self.assertEqual((none.returncode, none.stderr.count("\n")), (1, 1))
        self.assertIn(f"{elsewhere}/none.json: ", none.stderr)
        other = self.run_without_charts(self.records, "--output", output, "--gpu", self.records)
        self.assertEqual(other.returncode, 0)
        self.assertRegex(other.stderr, r"\Areport\.py: warning: records: .*Vulkan.*\n\Z")
        (elsewhere / "short.json").write_text("{")
        damaged = self.run_without_charts(self.records, "--output", output, "--gpu", elsewhere)
        self.assertEqual((damaged.returncode, damaged.stderr.count("\n")), (0, 1))
        self.assertIn("short.json: truncated", damaged.stderr)

    def test_scenes_with_the_same_name_and_different_sizes_are_separate(self):
        folder = Path(self.temporary.name) / "herds"
        folder.mkdir()
        for count in (8, 64):
            record = gpu_record(self.record(), ON_GPU)
            for group in record["groups"]:
                group.update(scene="herd", quads=group["quads"] * count)
            (folder / f"herd_{count}.json").write_text(json.dumps(record))
        data = self.data(folder)
        rows = gpu.device_views(data)
        self.assertEqual(sorted(rows[(rows["view"] == "full") & (rows.kind == "GRID")].level), [2, 2, 6, 6])
        (table,) = [part for part in gpu.section(data)[0] if isinstance(part, formats.Table)]
        sizes = {row[2] for row in table.rows if row[0] == "6"}
        quads = self.record()["groups"][1]["quads"]
        self.assertEqual(sizes, {f"{8 * quads / 1e6:.2f}", f"{64 * quads / 1e6:.2f}"})

    def test_real_device_is_reported(self):
        folder = Path(self.temporary.name) / "real"
        words = [
            "--scene",
            "cube",
            "--level",
            "2",
            "--representation",
            "grid,cvoxel",
            "--device",
            "vulkan",
            "--size",
            "32x32",
        ]
        words += ["--query", "closest,any", "--rays", "0", "--repeat", "2", "--true-surface", "0", "--check", "leaks"]
        words += ["--check-rays", "1000", "--json", folder / "gpu_cube_L2.json"]
        done = subprocess.run([BENCH, *words], capture_output=True, text=True)
        if done.returncode:
            self.skipTest(done.stderr.strip().split("\n")[-1])
        device = json.loads((folder / "gpu_cube_L2.json").read_text())["groups"][0]["results"][0]["on_device"]["device"]
        done = self.run_script(folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        html = sections_of((folder / "report.html").read_text())["gpu"]
        self.assertIn(device, html)
        self.assertIn("Leaks, sheets and shadows on the device", html)
        self.assertIn("cube: memory, speed", html)

    def test_kinds_match_those_of_the_programs(self):
        words = subprocess.run([BENCH, "--help"], capture_output=True, text=True, check=True).stdout
        self.assertIn(f" of {', '.join(kind.lower() for kind in KINDS)};", " ".join(words.split()))

    def test_front_contains_only_undominated_rows(self):
        frame = pandas.DataFrame([(1, 5), (2, 4), (2, 6), (3, 7), (0.5, 1)], columns=["error", "value"])
        for low, kept in ((False, [(0.5, 1), (1, 5), (2, 6), (3, 7)]), (True, [(0.5, 1)])):
            front = tradeoffs.front_of(frame, low)
            self.assertEqual(list(zip(front.error, front.value)), kept)

    def test_every_front_is_a_table_and_longer_ones_a_chart(self):
        folder = Path(self.temporary.name) / "fronts"
        folder.mkdir()
        record = self.record()
        for group in record["groups"]:
            for result in group["results"]:
                best = result["kind"] == "cLEAF-only"
                result["memory"]["live_bytes"] = 1000 if best else 2000
                for speed in result["speed"]:
                    speed["mrays_per_second"]["median"] = 1.0 if best else 2.0
                for view in result["views"]:
                    view["errors"]["p99_pixels"] = 0.0 if best else 1.0
        (folder / "cube_L2-6.json").write_text(json.dumps(record))
        charts, fold = tradeoffs.section(self.data(folder))[0]
        drawn = [f"{rays} rays against error, cube" for rays in ("coherent", "incoherent")]
        self.assertEqual([chart.text for chart in charts], drawn, "the front of memory has only one row")
        (memory_front,) = [part for part in fold.parts if "memory" in part.title]
        (row,) = [row for row in memory_front.rows if row[0] == "cLEAF-only^2"]
        self.assertEqual(row[1:3], ["6", "0"])


if __name__ == "__main__":
    unittest.main()
