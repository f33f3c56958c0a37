# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Tests the command line of scripts/benchmark.py, mostly with a replacement for cbvh_bench that answers immediately
and records its calls.

    benchmark_script.py PATH/TO/cbvh_bench
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts/benchmark.py"
BENCH = sys.argv.pop(1) if len(sys.argv) > 1 else ""

STAND_IN = """#!/usr/bin/python3
import json, os, signal, sys, time
folder = os.path.dirname(os.path.abspath(__file__))
mode = open(folder + "/mode").read()
words = sys.argv[1:]
if words == ["--about"]:
    print(json.dumps({"commit": open(folder + "/commit").read(), "isas": ["avx2"], "scenes": ["cube", "trex"],
                      "hardware_threads": 2}))
    sys.exit(0)
value = lambda name: words[words.index(name) + 1]
device = value("--device") if "--device" in words else ""
scene = value("--scene") if "--scene" in words else os.path.basename(value("--cage"))
with open(folder + "/calls", "a") as calls:
    calls.write(scene + " " + value("--level") + (" " + device if device else "") + "\\n")
if device and mode == "no device":
    print("cbvh_bench: Vulkan has no driver", file=sys.stderr)
    sys.exit(1)
results = []
if device:
    results = [{"representation": "GRID", "memory": {"live_bytes": 1}, "views": [], "speed": [], "on_device": {
        "device": open(folder + "/device").read(), "device_bytes": 1, "imported_bytes": 0, "upload_seconds": 0}}]
if mode == "fail":
    print("  cube: 0.1 s", file=sys.stderr)
    print("cbvh_bench: out of memory", file=sys.stderr)
    sys.exit(1)
levels = [int(level) for level in value("--level").split(",")]
groups = []
signal.signal(signal.SIGINT, lambda *_: sys.exit(130))
for level in levels:
    if mode == "slow" and level > levels[0]:
        time.sleep(60)
    groups.append({"scene": scene, "level": level, "quads": 1, "results": results})
    record = {"format": "cbvh-bench", "version": 2, "complete": level == levels[-1], "groups": groups,
              "run": {"commit": open(folder + "/commit").read(), "command": "cbvh_bench " + " ".join(words)}}
    with open(value("--json"), "w") as file:
        json.dump(record, file)
"""


class Benchmark(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)
        self.bench = self.folder / "bench"
        self.bench.write_text(STAND_IN)
        self.bench.chmod(0o755)
        self.output = self.folder / "out"
        self.set_mode("quick")
        (self.folder / "commit").write_text("abc")
        (self.folder / "device").write_text("Device One, driver 1")

    def set_mode(self, mode):
        (self.folder / "mode").write_text(mode)

    def command(self, *words):
        return [sys.executable, "-B", str(SCRIPT), *words, "--bench", str(self.bench), "--output", str(self.output)]

    def run_script(self, *words):
        return subprocess.run(self.command(*words), capture_output=True, text=True, timeout=100, cwd=self.folder)

    def calls(self):
        path = self.folder / "calls"
        lines = path.read_text().split("\n")[:-1] if path.exists() else []
        path.unlink(missing_ok=True)
        return lines

    def test_existing_records_are_not_measured_again(self):
        first = self.run_script("quick", "--scene", "cube")
        self.assertEqual(first.returncode, 0, first.stderr)
        self.assertEqual(self.calls(), ["cube 4,5,6,7,8", "cube:0.45 6"])
        second = self.run_script("quick", "--scene", "cube")
        self.assertEqual(second.returncode, 0, second.stderr)
        self.assertEqual(self.calls(), [])
        self.assertEqual(self.run_script("quick", "--scene", "cube", "--fresh").returncode, 0)
        self.assertEqual(len(self.calls()), 2)

    def test_interrupted_run_continues_without_loss(self):
        self.set_mode("slow")
        process = subprocess.Popen(
            self.command("quick", "--scene", "cube"), stdout=subprocess.PIPE, text=True, cwd=self.folder
        )
        record = self.output / "cube_L4-5-6-7-8.json"
        begin = time.monotonic()
        while not record.exists() and time.monotonic() - begin < 60:
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertIn("stopped", output)
        self.assertEqual(json.loads(record.read_text())["groups"][0]["level"], 4)
        self.calls()
        self.set_mode("quick")
        again = self.run_script("quick", "--scene", "cube")
        self.assertEqual(again.returncode, 0, again.stdout)
        self.assertEqual(self.calls(), ["cube 5,6,7,8", "cube:0.45 6"], "level 4 exists")
        self.assertTrue(record.exists())

    def test_truncated_record_is_reported_and_measured_again(self):
        self.run_script("quick", "--scene", "cube")
        self.calls()
        record = self.output / "cube_fivefold_L6.json"
        record.write_text(record.read_text()[:40])
        again = self.run_script("quick", "--scene", "cube")
        self.assertEqual(again.returncode, 0)
        lines = [line for line in again.stdout.split("\n") if "cube_fivefold_L6.json" in line]
        self.assertEqual(len(lines), 1, lines)
        self.assertIn("truncated", lines[0])
        self.assertEqual(self.calls(), ["cube:0.45 6"])
        json.loads(record.read_text())

    def test_old_record_is_kept_until_it_is_replaced(self):
        self.run_script("quick", "--scene", "cube")
        before = (self.output / "cube_fivefold_L6.json").read_text()
        self.set_mode("fail")
        failed = self.run_script("quick", "--scene", "cube", "--fresh")
        self.assertEqual((failed.returncode, failed.stdout.count("cbvh_bench: out of memory")), (1, 2), "both jobs ran")
        self.assertFalse((self.output / "cube_fivefold_L6.json").exists())
        self.assertEqual((self.output / "cube_fivefold_L6.json.old").read_text(), before)
        self.set_mode("quick")
        self.assertEqual(self.run_script("quick", "--scene", "cube").returncode, 0)
        self.assertEqual(list(self.output.glob("*.old")), [])

    def test_records_of_another_commit_are_measured_again(self):
        self.run_script("quick", "--scene", "cube")
        self.calls()
        (self.folder / "commit").write_text("def")
        again = self.run_script("quick", "--scene", "cube")
        self.assertRegex(again.stdout, r"cube_fivefold_L6\.json: .*\babc\b")
        self.assertEqual(len(self.calls()), 2)

    def test_invalid_names_are_reported_in_one_line(self):
        for words, message in (
            (["slow"], "set 'slow'.*quick"),
            (["quick", "--scene", "teapot"], "scene 'teapot'.*cube, trex"),
            (["--cage", "missing.obj"], r"missing\.obj: "),
            (["--cage", str(SCRIPT), "--height", "missing.exr"], r"missing\.exr: "),
            (["--height", "x.exr"], "--height .*--cage"),
            (["gpu", "--device", "nvidia"], "--device 'nvidia'.*vulkan:N"),
            (["--bench", "nothing"], "nothing: .*program"),
        ):
            command = self.command() + words if "--bench" in words else self.command(*words)
            done = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=self.folder)
            self.assertEqual(done.returncode, 1, words)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertRegex(done.stderr, message)
            self.assertEqual(self.calls(), [])

    def test_gpu_is_measured_with_cpu_reference(self):
        done = self.run_script("gpu-quick", "--scene", "cube")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("Vulkan device Device One, driver 1", done.stdout)
        self.assertEqual(self.calls(), ["cube 1 vulkan", "cube 4,5 vulkan", "cube 4,5"], "a probe, a device, a thread")
        self.run_script("gpu-quick", "--scene", "cube")
        self.assertEqual(self.calls(), ["cube 1 vulkan"], "all records exist")
        named = self.run_script("gpu-quick", "--scene", "cube", "--device", "vulkan:one 1", "--fresh")
        self.assertEqual(named.returncode, 0, named.stdout + named.stderr)
        self.assertEqual(self.calls(), ["cube 1 vulkan:one 1", "cube 4,5 vulkan:one 1", "cube 4,5"])

    def test_without_a_gpu_its_jobs_are_left_out_and_others_continue(self):
        self.set_mode("no device")
        done = self.run_script("gpu-quick", "--scene", "cube")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout.count("\n"), 1)
        self.assertRegex(done.stdout, "gpu_cube, gpu_cube_cpu, .*: Vulkan has no driver")
        self.assertEqual(self.calls(), ["cube 1 vulkan"])
        self.assertFalse(self.output.exists())
        done = self.run_script("full", "--scene", "cube")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("Vulkan has no driver", done.stdout)
        calls = self.calls()
        self.assertEqual([call for call in calls if "vulkan" in call], ["cube 1 vulkan"])
        self.assertIn("cube:0.45 6", calls)
        named = self.run_script("gpu", "--device", "vulkan:nvidia")
        self.assertEqual(named.returncode, 1)
        self.assertEqual(named.stderr, "benchmark.py: --device vulkan:nvidia: Vulkan has no driver\n")
        other = self.run_script("quick", "--device", "vulkan:nvidia")
        self.assertEqual((other.returncode, other.stderr.count("\n")), (1, 1))

    @unittest.skipUnless(BENCH, "requires cbvh_bench")
    def test_program_accepts_options_of_all_sets(self):
        """Checks that the program parses the arguments of each job: it stops because of an invalid option only after
        parsing."""
        sys.path.insert(0, str(SCRIPT.parent))
        import benchmark_sets as sets

        scenes = json.loads(subprocess.run([BENCH, "--about"], capture_output=True, text=True, check=True).stdout)[
            "scenes"
        ]
        for name in sets.NAMES:
            for job in sets.jobs_of(name, ["avx", "avx2"]):
                if job.scene.split(":")[0] not in scenes:
                    continue
                words = job.arguments
                if "--isa" in words:
                    words[words.index("--isa") + 1] = "best"
                place = ["--scene", job.scene, "--level", ",".join(map(str, job.levels))]
                command = [BENCH, *place, *words, "--build-threads", "-1"]
                done = subprocess.run(command, capture_output=True, text=True, timeout=60)
                if "no Vulkan" in done.stderr and job.needs_vulkan:
                    continue
                self.assertRegex(done.stderr, r"\Acbvh_bench: .*--build-threads -1\b.*\n\Z", (name, job.name))


if __name__ == "__main__":
    unittest.main()
