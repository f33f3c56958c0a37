# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""scripts/report.py from the outside, on a small record of cbvh_bench.

usage: report_script.py PATH/TO/cbvh_bench
"""

import json
import os
import random
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
import bench_records  # noqa: E402
import report_data  # noqa: E402
import report_figures  # noqa: E402
import report_gpu  # noqa: E402
import report_hard_cases  # noqa: E402
import report_isas  # noqa: E402
import report_labels  # noqa: E402
import report_levels  # noqa: E402
import report_markdown  # noqa: E402
import report_memory  # noqa: E402
import report_scale  # noqa: E402
import report_summary  # noqa: E402
import report_tradeoffs  # noqa: E402
from report_relations import relations  # noqa: E402

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
MOST_COLUMNS = 12  # that a window of 1024 pixels has room for


RAYS = [(ray_set, query) for ray_set in ("coherent", "incoherent") for query in ("closest", "any")]
GPU = "Device One, driver 1"


def gpu_record(record, mrays, device=GPU, bytes_a_quad=30000):
    """A record as if a device had measured it: mrays is the speed of each representation, bytes_a_quad what cVOXEL holds,
    a third of it on the device. Without a device, of the processor."""
    record = json.loads(json.dumps(record))
    if device:
        record["run"]["settings"]["device"] = "vulkan"
    for group in record["groups"]:
        for result in group["results"]:
            third = bytes_a_quad // 3 * TIMES[result["kind"]] * group["quads"]
            held = {"device_bytes": third, "imported_bytes": 2 * third}
            if device:
                result["on_device"] = {"device": device, "upload_seconds": 0.1, **held}
            result["memory"]["live_bytes"] *= 3  # other sections would show it
            template = result["speed"][0]
            result["speed"] = []
            for ray_set, query in RAYS:
                summary = {"min": mrays[result["kind"]], "max": mrays[result["kind"]], "spread": 0.0}
                ratio = mrays[result["kind"]] / mrays["GRID"]
                result["speed"].append(
                    {
                        **template,
                        "set": ray_set,
                        "query": query,
                        "mrays_per_second": {"median": mrays[result["kind"]], **summary},
                        "relative_to_grid": {"median": ratio, "min": ratio, "max": ratio, "spread": 0.0},
                    }
                )
    return record


TIMES = {"NAIVE": 16, "GRID": 4, "cGRID": 3, "cVOXEL": 1, "cLEAF": 2, "cLEAF-only": 2}
ON_GPU = {"NAIVE": 400.0, "GRID": 200.0, "cGRID": 100.0, "cVOXEL": 800.0, "cLEAF": 500.0, "cLEAF-only": 300.0}
ON_PROCESSOR = {kind: 2.0 for kind in ON_GPU}


def sections_of(html):
    """The HTML of each section by its name."""
    parts = html.split('<section><h2 id="')[1:]
    return {part[: part.index('"')]: part[: part.index("</section>")] for part in parts}


class Page(HTMLParser):
    """Checks that tags nest, and collects what refers to something."""

    VOID = {"meta", "img", "source", "br", "wbr"}

    def __init__(self, text):
        super().__init__()
        self.tables, self.unnamed = [], 0  # columns of each table that stacks; its cells that no name would stand beside
        self.stacks = False
        self.open, self.ids, self.references, self.alternatives = [], [], [], 0
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.ids += [found["id"]] if "id" in found else []
        self.references += [found[name] for name in ("src", "srcset", "href") if name in found]
        if tag == "table":
            self.stacks = "plain" in found["class"]
            self.tables += [0] if self.stacks else []
        if self.stacks and tag == "th":
            self.tables[-1] += 1
        if tag == "tr":
            self.cells = 0
        if tag == "td":
            self.unnamed += self.stacks and self.cells > 0 and not found.get("data-name")
            self.cells += 1
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
                "naive,cvoxel,cleaf,cleaf-only,cgrid^2",
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
        bodies = sections_of(html)
        for section in SECTIONS[:-2]:
            self.assertTrue("Made by" in bodies[section] or "No data" in bodies[section], section)
            self.assertLessEqual(bodies[section].count("Made by"), 1, section)
        self.assertIn("Noise.", bodies["run"])
        self.assertNotIn("-0.0000", html)
        self.assertGreater(len(page.tables), 10)
        self.assertLessEqual(max(page.tables), MOST_COLUMNS)
        self.assertEqual(page.unnamed, 0)
        tables = (folder / "tables.md").read_text()
        self.assertIn("| GRID |", tables)
        self.assertIn("| relation | paper | ours | verdict |", tables)

    def test_the_first_screen_is_the_result(self):
        done = self.run_script(self.records, "--output", Path(self.temporary.name) / "first.html")
        self.assertEqual(done.returncode, 0, done.stderr)
        first = (Path(self.temporary.name) / "first.html").read_text().split("<nav")[0]
        self.assertLess(first.count("<img"), 2)
        results = {r["representation"]: r for r in self.record()["groups"][1]["results"]}
        ours, grid = results["cLEAF^2"], results["GRID"]
        smaller = grid["memory"]["live_bytes"] / ours["memory"]["live_bytes"]
        self.assertIn(f"{report_summary.times(smaller)} times smaller", first)
        self.assertIn(f"{ours['memory']['bytes_per_quad']:.2f} bytes a quad", first)
        for ray_set in ("coherent", "incoherent"):
            (speed,) = [s for s in ours["speed"] if (s["view"], s["set"]) == ("full", ray_set)]
            self.assertIn(report_summary.times(speed["relative_to_grid"]["median"]), first)
        errors = next(view for view in ours["views"] if view["view"] == "full")["errors"]
        self.assertIn(f"{report_summary.two_digits(errors['p99_pixels'])} pixels of error", first)
        self.assertIn(f"{report_summary.two_digits(errors['median_pixels']).removeprefix('less than ')} (median)", first)
        self.assertNotIn("RMSE", first)
        exact = ours["memory"]["compression"]["exact_quads_share"]
        self.assertIn(f"Of cLEAF<sup>2</sup> {100 * exact:.0f}% of the quads are stored exactly", first)
        self.assertNotIn("scenes", first, "there is one")

    def test_the_first_screen_names_the_worst_of_all_scenes(self):
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
        data = report_data.Data(folder)
        found = report_summary.headline(data)
        self.assertEqual(found.row.scene, "trex")
        memory, speed, error = (over for *_, over in report_summary.statements(data, found).values())
        self.assertEqual(memory, "Over 2 scenes it is 5.0 to 20.0 times smaller, least for frog at level 6.")
        self.assertRegex(speed, "^Over 2 scenes and their views it is 0.12 to 1.50 times GRID's speed, least for trex, close view, ")
        self.assertEqual(error, "Over 2 scenes and their views it is 0.12 to 0.50 pixels, most for frog.")
        for text in (report_summary.first_screen(data), report_markdown.results(data)):
            self.assertIn("least for frog at level 6", text.replace("&#x27;", "'"))

    def test_errors_are_medians_and_p99_but_where_the_paper_s_stand(self):
        output = Path(self.temporary.name) / "errors.html"
        done = self.run_script(self.records, "--output", output)
        self.assertEqual(done.returncode, 0, done.stderr)
        bodies = sections_of(output.read_text())
        for name in ("tradeoffs", "errors", "gpu", "levels", "growth"):
            self.assertNotIn("RMSE", bodies[name], name)
        self.assertIn("p99", bodies["errors"])
        self.assertIn("RMSE", bodies["relations"])
        heads = [line for line in output.with_name("tables.md").read_text().split("\n") if "RMSE" in line and line.startswith("| level")]
        self.assertTrue(heads and all(line.count("RMSE") == line.count("the paper's RMSE") for line in heads), heads)

    def test_how_much_of_cleaf_is_stored_exactly_stands_beside_its_memory(self):
        results = {r["representation"]: r for r in self.record()["groups"][1]["results"]}
        exact, only = (results[label]["memory"]["compression"] for label in ("cLEAF^2", "cLEAF-only^2"))
        self.assertEqual(only["exact_quads"], 0)
        self.assertGreater(exact["exact_quads"], 0)
        percent = f"{100 * exact['exact_quads'] / exact['quads']:.1f}"
        self.assertAlmostEqual(exact["exact_quads_share"], exact["exact_quads"] / exact["quads"])
        data = report_data.Data(self.records)
        (table,) = [found for found in report_levels.tables(data, "cube") if found[0] == report_levels.EXACT]
        self.assertIn(("cLEAF^2", percent), [(row[0], row[2]) for row in table[2]])
        self.assertEqual({row[0] for row in table[2]}, {"cLEAF^2", "cLEAF^3"}, "no other has faces of two forms")
        lines = [line.split(" | ") for line in report_markdown.results(data).split("\n") if line.startswith("| 6 | cLEAF")]
        self.assertIn((percent, "-"), [(a[4], b[4]) for a in lines for b in lines if (a[1], b[1]) == ("cLEAF^2", "cLEAF-only^2")])

    def test_leaves_that_had_no_name_of_their_own_get_it(self):
        folder = Path(self.temporary.name) / "old"
        folder.mkdir()
        record = self.record()
        record["run"]["settings"]["leaves_only"] = True
        for group in record["groups"]:
            group["results"] = [r for r in group["results"] if r["kind"] != "cLEAF-only"]
        (folder / "cube_L2-6.json").write_text(json.dumps(record))
        found = {(r["representation"], r["kind"]) for r in bench_records.read(folder / "cube_L2-6.json")["groups"][0]["results"]}
        self.assertIn(("cLEAF-only^2", "cLEAF-only"), found)
        self.assertNotIn("cLEAF", {kind for _, kind in found})

    def test_dark_pictures_have_other_ink(self):
        pictures = report_figures.themed(lambda axes, theme: axes.set_title("x"))
        for here, other in (("light", "dark"), ("dark", "light")):
            for colour in report_figures.THEMES[here].values():
                self.assertIn(colour.encode(), pictures[here])
                self.assertNotIn(colour.encode(), pictures[other])

    def test_bytes_are_in_parts_that_add_up(self):
        for row in report_data.Data(self.records).rows:
            parts = report_memory.parts(row)
            self.assertEqual(sum(parts.values()), row.bytes, row.label)
            self.assertGreaterEqual(min(parts.values()), 0, row.label)

    def test_numbers_and_axes_are_readable(self):
        self.assertEqual(report_figures.signed(-0.00001), "0.0000")
        self.assertEqual(report_figures.signed(-0.0002), "-0.0002")
        for low, high in ((0.9, 1.2), (3, 40), (0.5, 9), (1e-3, 1e4), (2e-5, 3e-5), (1, 1e12)):
            ticks = report_figures.LogLabels().tick_values(low, high)
            self.assertTrue(3 <= len(ticks) <= 7, (low, high, ticks))
            self.assertTrue(all(0.999 * low <= tick <= 1.001 * high for tick in ticks))

    def test_instruction_sets_of_another_machine_stand_beside_this_one_s(self):
        folder = Path(self.temporary.name) / "another"
        folder.mkdir()
        record = self.record()
        record["run"].update(cpu="Processor elsewhere", commit="c0ffee")
        for group in record["groups"]:
            for result in group["results"]:
                result["isa"] = "avx512"
        (folder / "cube_L2-6.json").write_text(json.dumps(record))
        data = report_data.Data(self.records)
        before = data.isa, len(data.rows)
        self.assertEqual(report_isas.compared(data), {})
        data.add_elsewhere(folder)
        self.assertEqual((data.isa, len(data.rows)), before, "no other section shows it")
        names, rows = report_isas.table(report_isas.compared(data)["cube", 6], "coherent")
        self.assertEqual(len(names), 2)
        self.assertEqual(names[-1], "avx512, Processor elsewhere")
        self.assertEqual(len(rows[0][1]), 2 * len(report_isas.HEADS))
        output = Path(self.temporary.name) / "beside.html"
        done = self.run_script(self.records, "--output", output, "--beside", folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("Processor elsewhere", sections_of(output.read_text())["isas"])
        self.assertIn("Processor elsewhere", output.with_name("tables.md").read_text())
        none = self.run_script(self.records, "--output", output, "--beside", folder / "none")
        self.assertEqual((none.returncode, none.stderr.count("\n")), (1, 1))

    def test_the_tables_in_markdown_have_what_was_measured(self):
        folder = self.gpu_folder("markdown", {})
        record = self.record()
        for group in record["groups"]:
            results = group["results"]
            group["results"] = [{**r, "isa": isa} for isa in ("sse4.2", "avx", results[0]["isa"]) for r in results]
        (folder / "isas_L2-6.json").write_text(json.dumps(record))
        data = report_data.Data(folder)
        text = report_markdown.results(data)
        heads = [line for line in text.split("\n") if line.startswith("#")]
        for head in ("## cube", "### cube: error", "### cube, level 6, incoherent", "### cube: bytes a quad"):
            self.assertIn(head, heads)
        width = 0
        for line in text.split("\n"):
            if line.startswith("|"):
                width = width or line.count("|")
                self.assertEqual(line.count("|"), width, line)
            else:
                width = 0
        (isas,) = [isas for (_, level), isas in report_isas.compared(data).items() if level == 6]
        self.assertLessEqual({"sse4.2", "avx"}, {isa for isa, _ in isas})
        names, rows = report_isas.table(isas, "coherent")
        self.assertEqual({len(cells) for _, cells in rows}, {len(names) * len(report_isas.HEADS)})
        heads, rows = report_levels.table(data, "cube", report_levels.bytes_text)
        self.assertEqual(heads, ["level 2", "level 6"])
        self.assertIn("cVOXEL^3", [row[0] for row in rows])
        six = next(row for row in data.rows if (row.label, row.level) == ("cLEAF^3", 6))
        self.assertIn(["cLEAF^3", f"{six.memory['bytes_per_quad']:.2f}"], [[row[0], row[2]] for row in rows])

    def test_scale_stands_in_the_page_where_it_was_measured(self):
        speed = {ray_set: {"closest": {"mrays_per_second": rays}} for ray_set, rays in (("coherent", 1.5), ("incoherent", 0.75))}
        opened = {"openSeconds": 0.25, "pictureSeconds": 40, "quads": 2 * 10**9, "speed": speed}
        herd = {
            "count": 62, "level": "6", "quads": 2 * 10**9, "fileBytes": 5 * 2**30, "found": 41, "lastQuads": 6 * 10**8, "lastSeconds": 30,
            "stops": [{"seconds": 40, "bytes": 2**30, "signal": "SIGINT"}, {"seconds": 20, "bytes": 3 * 2**30, "signal": "SIGKILL"}],
            "buildSeconds": 90, "ownBytes": 2**27, "cold": opened, "warm": opened, "coldMapped": 2**30, "renderOwnBytes": 2**28,
            "size": "64x48", "samples": 4, "picture": "none.png", "threads": 2, "memory": 2**34, "commands": ["render the herd"],
            "deviceBytes": 2**26, "some": {"count": 2, "quads": 10**8, "bytes": 2**24, "fileBytes": 2**28, "speed": speed, "command": "render some"},
            "beside": [{"count": 2, "representation": "GRID", "quads": 10**8, "bytes": 4 * 10**9, "peak": 5 * 10**9, "buildSeconds": 9,
                        "speed": speed, "command": "render GRID"}],
        }  # fmt: skip
        level = {"scene": "trex", "view": "full", "level": "auto", "quads": 10**6, "live_bytes": 2**22, "build_seconds": 0.5, "speed": speed,
                 "errors_to_true_surface": {"median_pixels": 0.125, "p99_pixels": 0.5}, "size": "64x48", "command": "render levels"}  # fmt: skip
        folder = Path(self.temporary.name) / "scale"
        folder.mkdir()
        (folder / report_scale.RECORD).write_text(json.dumps({"date": "2026-01-01", "herd": herd, "levels": [level]}))
        text = "\n".join(report_scale.markdown(report_scale.read(folder)))
        for found in ("20.0 million quads a second", "74.5 GiB, reckoned from 40.0 bytes a quad", "interrupted at 1.0 GiB and killed at 3.0 GiB",
                      "0.34 billion", "| trex, full | auto | 1.00 | 4.0 |"):  # fmt: skip
            self.assertIn(found, text)
        page = Path(self.temporary.name) / "scale.html"
        self.assertEqual(self.run_script(self.records, "--scale", folder, "--output", page).returncode, 0)
        for found in ("reckoned from 40.0 bytes a quad", "Levels by the view", "render GRID"):
            self.assertIn(found, page.read_text())
        done = self.run_script(self.records, "--scale", self.records, "--output", page)
        self.assertIn("measure_scale.py makes it", done.stderr)

    def own_records(self, name):
        """The records as if they were of a cage of the user's."""
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

    def test_a_cage_of_one_s_own_gets_no_empty_sections(self):
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

    def test_the_measurement_has_a_start_and_an_end(self):
        run = self.record()["run"]
        self.assertGreater(run["end"], run["date"])
        self.assertEqual(report_data.period([run]), f"{run['date']} to {run['end']}")
        older, later = {"date": "2026-01-02T00:00:00Z"}, {"date": "2026-01-01T00:00:00Z", "end": "2026-01-03T00:00:00Z"}
        self.assertEqual(report_data.period([older]), older["date"])
        self.assertEqual(report_data.period([older, later]), f"{later['date']} to {later['end']}")
        page = Path(self.temporary.name) / "period.html"
        self.assertEqual(self.run_script(self.records, "--output", page).returncode, 0)
        for text in (page.read_text(), page.with_name("tables.md").read_text()):
            self.assertIn(f"{run['date']} to {run['end']}", text)

    def test_a_missing_matplotlib_is_one_line_that_names_the_package(self):
        without = Path(self.temporary.name) / "no_matplotlib"
        (without / "matplotlib").mkdir(parents=True)
        (without / "matplotlib/__init__.py").write_text("raise ModuleNotFoundError(name='matplotlib')\n")
        environment = {**os.environ, "PYTHONPATH": str(without)}
        for script in (SCRIPT, SCRIPT.with_name("claims.py")):
            command = [sys.executable, "-B", str(script), str(self.records)]
            done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn("python3-matplotlib", done.stderr)

    def test_the_page_goes_through_links_and_into_devices_and_over_no_record(self):
        folder = Path(self.temporary.name) / "outputs"
        shutil.copytree(self.records, folder)
        before = {path: path.read_bytes() for path in folder.glob("*.json")}
        (folder / "store").mkdir()
        (folder / "link.html").symlink_to("store/page.html")
        (folder / "null").symlink_to("/dev/null")
        done = self.run_script(folder, "--output", folder / "link.html", "--tables", folder / "null")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((folder / "link.html").is_symlink() and (folder / "null").is_symlink())
        self.assertIn("<h1>", (folder / "store/page.html").read_text())
        self.assertEqual(len(list(folder.iterdir())), 3 + len(before) + 1, "a part is left")
        (folder / "store/page.html").chmod(0o604)
        done = self.run_script(folder, "--output", folder / "link.html", "--tables", "/dev/stdout")
        self.assertIn("| relation | paper |", done.stdout)
        self.assertEqual((folder / "store/page.html").stat().st_mode & 0o7777, 0o604)
        (folder / "same.html").symlink_to("cube_L2-6.json")
        for words in (
            ["--output", folder / "cube_L2-6.json"],
            ["--tables", folder / "same.html"],
            ["--against", self.records, "--output", self.records / "cube_L2-6.json"],
        ):
            done = self.run_script(folder, *words)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
            self.assertIn("would replace the record cube_L2-6.json", done.stderr)
        done = self.run_script(folder, "--output", folder / "one", "--tables", folder / "./one")
        self.assertIn("is the file of --output and of --tables", done.stderr)
        self.assertEqual(before, {path: path.read_bytes() for path in before})

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
        self.assertIsNotNone(report_data.noise(data.rows))

    def test_errors_against_a_finer_mesh_come_from_the_job_that_has_them(self):
        folder = Path(self.temporary.name) / "finer"
        shutil.copytree(self.records, folder)
        value = report_tradeoffs.speed_value("coherent")
        points, finer = report_tradeoffs.points_of(report_data.Data(folder), "cube", "full", value)
        self.assertFalse(finer)
        self.assertEqual({row.level for row, _, _ in points}, {6})
        record = json.loads((folder / "cube_L2-6.json").read_text())
        for group in record["groups"]:
            for result in group["results"]:
                for view in result["views"]:
                    view["errors_to_reference_level"] = view["errors"]
        (folder / "levels_L2-6.json").write_text(json.dumps(record))
        points, finer = report_tradeoffs.points_of(report_data.Data(folder), "cube", "full", value)
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
            next(r for r in results if r["representation"] == "cLEAF-only^2")["memory"]["live_bytes"] = int(part * grid)
            (folder / "cube_L6.json").write_text(json.dumps(record))
            table = {r.claim: r for r in relations(report_data.Data(folder))}
            claim = "cube: memory of cLEAF-only^2 at level 6 as a part of GRID at level 6"
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

    def gpu_folder(self, name, files):
        """Records of the processor, and others. files: name and record."""
        folder = Path(self.temporary.name) / name
        shutil.copytree(self.records, folder)
        for file, record in files.items():
            (folder / file).write_text(json.dumps(record))
        return folder

    def record(self):
        return json.loads((self.records / "cube_L2-6.json").read_text())

    def test_what_a_gpu_measured_is_in_its_section_alone(self):
        of_gpu, beside = gpu_record(self.record(), ON_GPU), gpu_record(self.record(), ON_PROCESSOR, None)
        bare = gpu_record(self.record(), ON_GPU)
        for result in bare["groups"][0]["results"]:
            del result["on_device"]  # the run's settings say it alone
        files = {"other_L2-6.json": of_gpu, "gpu_cube_cpu_L2-6.json": beside, "bare_L2-6.json": bare}
        pages, tables = [], []
        for folder in (self.gpu_folder("without", {}), self.gpu_folder("with", files)):
            done = self.run_script(folder)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            pages.append(sections_of((folder / "report.html").read_text()))
            tables.append((folder / "tables.md").read_text())
        self.assertEqual(list(pages[0]), list(SECTIONS))
        self.assertEqual([name for name in SECTIONS if pages[0][name] != pages[1][name]], ["gpu", "run"])
        self.assertIn("1 in <code>", pages[0]["run"])
        self.assertIn("4 in <code>", pages[1]["run"])
        self.assertIn("No data", pages[0]["gpu"])
        self.assertIn(GPU, pages[1]["gpu"])
        self.assertIn("Made by", pages[1]["gpu"])
        self.assertGreaterEqual(pages[1]["gpu"].count("<img"), 3)
        without = tables[1].split("## GPU")[0]
        self.assertTrue(tables[0].startswith(without))
        self.assertIn(GPU, tables[1])

    def test_ratios_of_a_gpu_are_to_grid_naive_and_the_processor_of_the_same_picture(self):
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
            (device,) = report_gpu.devices(report_data.Data(folder))
            (shown,) = [shown for shown in device.shown if shown.view == "full"]
            self.assertEqual((shown.scene, shown.main_size()[0]), ("cube", 6))
            rows, rays = shown.rows[shown.main_size()], report_gpu.RAYS[3]
            row = rows["cLEAF^2"]
            self.assertEqual(report_gpu.speed(row, "full", rays), 500)
            self.assertEqual(report_gpu.to_grid(row, "full", rays), 2.5)
            self.assertEqual(report_gpu.to_naive(row, rows["NAIVE"], "full", rays), 1.25)
            self.assertEqual(report_gpu.to_processor(row, device.beside(row), "full", rays), ratio)
            self.assertEqual(row.held_per_quad, 60000)
            words = report_gpu.in_words(device, shown)
            self.assertIn("cVOXEL<sup>3</sup> are the smallest with 30000 bytes a quad, 25% of GRID's 120000, at 4.00", words)
            self.assertIn("the fastest is with coherent rays cVOXEL<sup>2</sup> (4.00 times GRID)", words)
            self.assertEqual("the device has 50.0 to 400 times the speed of one thread" in words, ratio is not None)

    def test_memory_of_buffers_that_are_not_full_is_no_representation_s(self):
        folder = Path(self.temporary.name) / "small"
        folder.mkdir()
        (folder / "small.json").write_text(json.dumps(gpu_record(self.record(), ON_GPU, bytes_a_quad=3)))
        data = report_data.Data(folder)
        html = report_gpu.section(data)
        self.assertIn("does not tell representations apart", html)
        self.assertNotIn("smallest", html)
        self.assertNotIn("<img", html)

    def test_records_of_a_gpu_elsewhere_are_added(self):
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
            self.assertEqual(html.split("<nav")[0], plain.split("<nav")[0], "of this machine")
        none = self.run_script(self.records, "--output", output, "--gpu", elsewhere / "none.json")
        self.assertEqual((none.returncode, none.stderr.count("\n")), (1, 1))
        self.assertIn("no such file or folder", none.stderr)
        other = self.run_script(self.records, "--output", output, "--gpu", self.records)
        self.assertEqual(other.returncode, 0)
        self.assertEqual(other.stderr, "report.py: warning: records: nothing in it was measured on a Vulkan device; left out\n")
        (elsewhere / "short.json").write_text("{")
        damaged = self.run_script(self.records, "--output", output, "--gpu", elsewhere)
        self.assertEqual((damaged.returncode, damaged.stderr.count("\n")), (0, 1))
        self.assertIn("short.json: truncated or no JSON", damaged.stderr)

    def test_scenes_of_one_name_and_several_sizes_stay_apart(self):
        folder = Path(self.temporary.name) / "herds"
        folder.mkdir()
        for count in (8, 64):
            record = gpu_record(self.record(), ON_GPU)
            for group in record["groups"]:
                group.update(scene="herd", quads=group["quads"] * count)
            (folder / f"herd_{count}.json").write_text(json.dumps(record))
        (device,) = report_gpu.devices(report_data.Data(folder))
        shown = device.shown[0]
        self.assertEqual([level for level, _ in shown.sizes()], [2, 2, 6, 6])
        self.assertIn("million quads", shown.size_name(shown.sizes()[3]))
        Page(report_gpu.section(report_data.Data(folder)))

    def test_a_real_device_is_reported(self):
        folder = Path(self.temporary.name) / "real"
        words = ["--scene", "cube", "--level", "2", "--representation", "grid,cvoxel", "--device", "vulkan", "--size", "32x32"]
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
        self.assertIn("cube, level 2, speed, and how many times that of GRID", html)

    def test_kinds_are_those_of_the_programs(self):
        words = subprocess.run([BENCH, "--help"], capture_output=True, text=True, check=True).stdout
        self.assertIn(f" of {', '.join(kind.lower() for kind in report_data.KINDS)};", " ".join(words.split()))

    def test_labels_of_a_chart_cover_nothing(self):
        random.seed(7)
        bounds = (0, 0, 200, 150)
        marks = [(random.uniform(0, 200), random.uniform(0, 150), random.uniform(4, 9), "7") for _ in range(60)]
        marks += [(100, 75, 6, "12")] * 2
        line = report_labels.corners([(0, 20), (90, 20), (90, 120), (200, 120)])
        places = report_labels.place_labels(marks + [(10, 10, 5, "")], bounds, line)
        self.assertGreater(len(places), 40)
        self.assertNotIn(len(marks), places)
        boxes = [report_labels.box(x, y, size, size) for x, y, size, _ in marks] + line
        for i, (x, y) in places.items():
            here = report_labels.box(x, y, report_labels.DIGIT[0] * len(marks[i][3]), report_labels.DIGIT[1])
            self.assertFalse(any(report_labels.overlap(here, other) for other in boxes), i)
            self.assertTrue(bounds[0] <= here[0] and bounds[1] <= here[1] and here[2] <= bounds[2] and here[3] <= bounds[3])
            boxes.append(here)

    def test_the_front_keeps_what_nothing_beats(self):
        points = [(1, 5), (2, 4), (2, 6), (3, 7), (0.5, 1)]
        self.assertEqual(report_tradeoffs.pareto(points, False), [(0.5, 1), (1, 5), (2, 6), (3, 7)])
        self.assertEqual(report_tradeoffs.pareto(points, True), [(0.5, 1)])

    def test_a_front_of_one_is_a_sentence_and_no_plot(self):
        row = next(row for row in report_data.Data(self.records).rows if (row.label, row.level) == ("cLEAF-only^2", 6))
        two = [(row, 0.5, 3.0), (row, 0.1, 2.0)]
        self.assertEqual(report_tradeoffs.best_in_words("cube, speed", "rays", two, False), "")
        words = report_tradeoffs.best_in_words("cube, memory", "MiB", two, True)
        self.assertIn("cLEAF-only<sup>2</sup> at level 6 is the best of 2 in both: 2 MiB; p99 0.1 pixels", words)
        folder = Path(self.temporary.name) / "fronts"
        folder.mkdir()
        record = self.record()
        for group in record["groups"]:
            for result in group["results"]:
                best = result["kind"] == "cLEAF-only"
                result["memory"]["live_bytes"] = 1000 if best else 2000
                for view in result["views"]:
                    view["errors"]["p99_pixels"] = 0.0 if best else 1.0
        (folder / "cube_L2-6.json").write_text(json.dumps(record))
        html = report_tradeoffs.section(report_data.Data(folder))
        self.assertNotIn("memory against error, cube", html)
        self.assertIn("is the best of", html)


if __name__ == "__main__":
    unittest.main()
