# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Tests that scripts/report.py shows what records of cbvh_bench contain, and only in the sections where it belongs.

    report_script.py PATH/TO/cbvh_bench
"""

import json
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts/report.py"
BENCH = sys.argv.pop(1)
sys.path.insert(0, str(SCRIPT.parent))
import pandas  # noqa: E402

from reporting import gpu, relations, scale, tables  # noqa: E402
from reporting.data import KINDS, Data  # noqa: E402

OPTIONS = """--scene cube --level 2,6 --view full,close --representation naive,cvoxel,cleaf,cleaf-only,cgrid^2
    --frame-level 2,3 --rays 300 --repeat 3 --size 48x48 --check leaks,shadows --check-rays 2000""".split()


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.records = Path(cls.temporary.name) / "records"
        cls.records.mkdir()
        command = [BENCH, *OPTIONS, "--json", str(cls.records / "cube_L2-6.json")]
        subprocess.run(command, check=True, capture_output=True)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def record(self):
        return json.loads((self.records / "cube_L2-6.json").read_text())

    def folder(self, name, **records):
        """Returns a new folder with these records."""
        folder = Path(self.temporary.name) / name
        folder.mkdir()
        for file, record in records.items():
            (folder / f"{file}_L2-6.json").write_text(json.dumps(record))
        return folder

    def run_script(self, *words):
        command = [sys.executable, "-B", str(SCRIPT), *map(str, words)]
        return subprocess.run(command, capture_output=True, text=True, timeout=200)

    def sections(self, folder, *words):
        """Runs the script, and returns its sections by title."""
        done = self.run_script(folder, *words)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return dict(part.split("\n", 1) for part in (folder / "report.md").read_text().split("\n## ")[1:])

    def test_report_and_csv_contain_the_measurements(self):
        folder = self.folder("whole", cube=self.record())
        found = self.sections(folder)
        (ours,) = [r for r in self.record()["groups"][1]["results"] if r["representation"] == "cLEAF^2"]
        (speed,) = [s for s in ours["speed"] if (s["view"], s["ray_set"]) == ("full", "coherent")]
        memory, median = ours["memory"], speed["mrays_per_second"]["median"]
        self.assertRegex(found["cube"], rf"\| 6 \| cLEAF\^2 \|.* {memory['bytes_per_quad']:.2f} \|.* {median:.3f} \|")
        self.assertRegex(found["cube"], r"\| 6 \| cLEAF\^2 \| close \|")
        self.assertEqual(xml.parse(folder / "cube.svg").getroot().tag, "{http://www.w3.org/2000/svg}svg")
        self.assertIn("(cube.svg)", found["cube"])
        self.assertIn("### Leaks", found["Leaks, sheets and shadows"])
        self.assertIn("Not measured", found["GPU"])
        self.assertRegex(found["The run, and its noise"], r"Noise: .* spreads by [\d.]+%")
        self.assertIn("cbvh_bench --scene cube --level 2,6", found["Commands"])
        for block in re.findall(r"(?:^\|.*\n)+", (folder / "report.md").read_text(), re.M):
            self.assertEqual(len({line.count("|") for line in block.splitlines()}), 1, block)
        table = pandas.read_csv(folder / "records.csv", float_precision="round_trip")
        every = [speed for group in self.record()["groups"] for result in group["results"] for speed in result["speed"]]
        self.assertEqual((table.what == "speed").sum(), len(every))
        row = table[(table.representation == "cLEAF^2") & (table.level == 6) & (table["view"] == "full")]
        self.assertEqual(row[row.ray_set == "coherent"].mrays_per_second_median.item(), median)
        page = (SCRIPT.parents[1] / "docs/paper.md").read_text()  # its example reads the file
        (code,) = re.findall(r"^    import pandas\n(?:    .*\n)+", page, re.MULTILINE)
        names = {}
        exec(re.sub(r"(?m)^    ", "", code).replace("output/benchmark/paper", str(folder)), names)
        self.assertGreater(len(names["table"]), 5)

    def test_damaged_records_and_folders_are_reported_in_one_line(self):
        folder = self.folder("damaged", cube=self.record())
        (folder / "short_L4.json").write_text(json.dumps(self.record())[:1000])
        done = self.run_script(folder)
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stderr, r"\Areport\.py: warning: short_L4\.json: truncated.*\n\Z")
        for words in ([self.folder("empty")], [folder / "none"], [folder, "--gpu", folder / "none"]):
            done = self.run_script(*words)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)

    def test_relations_are_judged_by_numbers(self):
        record = self.record()
        results = next(group for group in record["groups"] if group["level"] == 6)["results"]
        memory = {result["representation"]: result["memory"] for result in results}
        for part, holds in ((0.31, True), (0.32, False)):
            memory["cLEAF-only^2"]["live_bytes"] = int(part * memory["GRID"]["live_bytes"])
            found = {r.claim: r for r in relations.relations(Data(self.folder(f"judged {part}", cube=record)))}
            claim = "cube: memory of cLEAF-only^2 at level 6 as a part of GRID at level 6"
            self.assertEqual(found[claim].holds, holds)
            missing = [
                r.holds for r in found.values() if "trex" in r.claim
            ]  # a mean over levels needs all of them, too
            self.assertEqual(set(missing), {None})

    def test_own_cage_is_not_compared_with_the_paper(self):
        record = self.record()
        record["run"]["command"] = record["run"]["command"].replace("--scene cube", "--cage cube.obj")
        found = self.sections(self.folder("own", cube=record))
        self.assertIn("cube", found)
        self.assertFalse({"The paper's statements", "GPU"} & set(found))

    def test_devices_and_other_machines_are_only_in_their_sections(self):
        device, elsewhere = self.record(), self.record()
        for group in device["groups"]:
            for result in group["results"]:
                held = {"device_bytes": 100 * group["quads"], "imported_bytes": 200 * group["quads"]}
                result["on_device"] = {"device": "Device One", "upload_seconds": 0.1, **held}
        elsewhere["run"].update(cpu="Processor elsewhere", commit="c0ffee")
        for result in (result for group in elsewhere["groups"] for result in group["results"]):
            result["isa"] = "avx512"
        folder, others = self.folder("here", cube=self.record()), self.folder("elsewhere", cube=elsewhere)
        before = self.sections(folder)
        after = self.sections(folder, "--gpu", self.folder("gpu", trex=device), "--other-machine", others)
        changed = {title for title in after if before.get(title) != after[title]}
        self.assertEqual(changed, {"GPU", "Instruction sets", "Leaks, sheets and shadows", "Commands"} & changed)
        self.assertIn("Device One", after["GPU"])
        self.assertIn("Processor elsewhere", after["Instruction sets"])
        data = Data(folder, [Path(self.temporary.name) / "gpu"])
        rows = gpu.device_views(data)
        self.assertEqual(set(rows.held_per_quad), {300})
        self.assertLessEqual((rows.coherent_of_cpu.dropna() - 1).abs().max(), 1e-6)  # the same picture as on the CPU

    def test_scale_and_hard_cases_are_shown(self):
        speed = {rays: {"closest": {"mrays_per_second": 1.5}} for rays in ("coherent", "incoherent")}
        level = {"scene": "trex", "view": "full", "level": "auto", "quads": 10**6, "live_bytes": 2**22,
                 "build_seconds": 0.5, "speed": speed, "size": "64x48", "command": "render levels",
                 "errors_to_true_surface": {"median_pixels": 0.125, "p99_pixels": 0.5}}  # fmt: skip
        (table,) = scale.tables({"levels": [level]})
        self.assertIn("| trex, full | auto | 1.00 | 4.0 |", table.markdown())
        folder = self.folder("hard cases")
        for isa, result in (("sse2", ""), ("avx2", '<failure message="t is &lt; 0"/>'), ("avx512", "<skipped/>")):
            (folder / f"{isa}.xml").write_text(
                f'<testsuites><testsuite><testcase name="AlongAxes/cLEAF_{isa}" classname="HardCases/HardRays">{result}'
                '<properties><property name="property" value="rays &gt; boxes"/></properties>'
                "</testcase></testsuite></testsuites>"
            )
        (folder / "stopped.xml").write_text("<testsuites><testsuite>")
        (table,) = tables.hard_cases(folder)
        self.assertEqual(table.rows, [["HardRays.AlongAxes", "rays > boxes", "1", "1", "1"]])

    def test_kinds_match_those_of_the_programs(self):
        words = subprocess.run([BENCH, "--help"], capture_output=True, text=True, check=True).stdout
        self.assertIn(f" of {', '.join(kind.lower() for kind in KINDS)};", " ".join(words.split()))


if __name__ == "__main__":
    unittest.main()
