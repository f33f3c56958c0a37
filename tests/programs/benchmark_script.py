# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Tests the command line of scripts/benchmark.py, mostly with a replacement for cbvh_bench that answers immediately
and records its calls.

    benchmark_script.py PATH/TO/cbvh_bench
"""

import json
import os
import re
import shlex
import shutil
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
import json, os, resource, signal, sys, time
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
if device and mode == "no float64" and "cvert" in value("--representation"):
    print("cbvh_bench: the device has no shaderFloat64", file=sys.stderr)
    sys.exit(1)
if device and mode == "small" and value("--level") != "1":
    print("cbvh_bench: Embree, putting a scene on a Vulkan device: out of memory: nodes", file=sys.stderr)
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
    if mode == "disk" and level > levels[0]:  # simulates a full disk, also for the script
        for process in (os.getppid(), os.getpid()):
            resource.prlimit(process, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
        print("  cube: 0.1 s\\ncbvh_bench: " + value("--json") + ": cannot be written", file=sys.stderr)
        sys.exit(1)
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

    def test_full_disk_is_reported_without_loss(self):
        self.set_mode("disk")
        full = self.run_script("quick", "--scene", "cube")
        self.assertEqual(full.returncode, 1)
        self.assertEqual(full.stderr.count("\n"), 1, full.stderr)
        self.assertRegex(full.stderr, f"{self.output}: .*File too large")
        self.assertEqual(self.calls(), ["cube 4,5,6,7,8"], "the next job must not start")
        record = json.loads((self.output / "cube_L4-5-6-7-8.json").read_text())
        self.assertEqual([group["level"] for group in record["groups"]], [4])
        self.assertFalse((self.output / ".room").exists())
        self.set_mode("quick")
        self.assertEqual(self.run_script("quick", "--scene", "cube").returncode, 0)
        self.assertEqual(self.calls(), ["cube 5,6,7,8", "cube:0.45 6"])

    def test_unwritable_log_does_not_stop_the_run(self):
        self.output.mkdir()
        (self.output / "cube.log").symlink_to("/dev/full")
        done = self.run_script("quick", "--scene", "cube")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(len(self.calls()), 2)

    def test_old_record_is_kept_until_it_is_replaced(self):
        self.run_script("quick", "--scene", "cube")
        before = (self.output / "cube_fivefold_L6.json").read_text()
        self.set_mode("fail")
        self.assertEqual(self.run_script("quick", "--scene", "cube", "--fresh").returncode, 1)
        self.assertFalse((self.output / "cube_fivefold_L6.json").exists())
        self.assertEqual((self.output / "cube_fivefold_L6.json.old").read_text(), before)
        self.set_mode("quick")
        self.assertEqual(self.run_script("quick", "--scene", "cube").returncode, 0)
        self.assertEqual(list(self.output.glob("*.old")), [])

    def test_jobs_are_chosen_by_name(self):
        done = self.run_script("full", "--job", "frames_*", "--job", "cube_fivefold")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(self.calls(), ["cube:0.45 6", "cube 4,5,6,7,8", "trex 4,5,6,7,8"])
        other = self.run_script("quick", "--job", "frames_*")
        self.assertEqual((other.returncode, other.stderr.count("\n")), (1, 1))
        self.assertRegex(other.stderr, r"job 'frames_\*' .*'quick'.*cube_fivefold")

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

    def test_failed_job_is_reported_and_others_continue(self):
        self.set_mode("fail")
        done = self.run_script("quick", "--scene", "cube")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stdout.count("cbvh_bench: out of memory"), 2)
        self.assertEqual(len(self.calls()), 2)

    def test_missing_scenes_are_left_out_with_a_message(self):
        done = self.run_script("quick", "--list")
        self.assertIn("scene 'frog'", done.stdout)
        self.assertIn("trex", done.stdout)

    def test_only_the_list_shows_durations(self):
        output = self.run_script("--help").stdout
        self.assertNotRegex(output, r"minute|second|\bhour")
        self.assertRegex(output, r"--list[^-]*how long")
        total = re.search(r"jobs, about (\d+):(\d\d)", self.run_script("quick", "--list").stdout)
        listed = re.findall(r"(?m) about (\d+):(\d\d)$", self.run_script("quick", "--list").stdout)
        jobs = [int(m) * 60 + int(s) for m, s in listed]
        self.assertAlmostEqual(int(total[1]) * 60 + int(total[2]), sum(jobs), delta=len(jobs))

    def test_durations_are_reported_as_measured(self):
        self.assertIn("as planned", self.run_script("quick", "--list").stdout)
        self.run_script("quick", "--scene", "cube")
        output = self.run_script("quick", "--list").stdout
        self.assertRegex(output, r"(?m)^cube  .* took 0:0\d$")
        self.assertRegex(output, r"(?m)^trex  .* about 0:\d\d$", "at the pace of the others")
        times = self.output / "job_times"
        for damaged in ("", "[1]", '{"x": {"seconds": "fast"}}'):
            times.write_text(damaged)
            self.assertIn("as planned", self.run_script("quick", "--list").stdout, damaged)

    def test_list_does_not_require_a_build(self):
        scripts = self.folder / "tree/scripts"
        shutil.copytree(SCRIPT.parent, scripts, ignore=shutil.ignore_patterns("__pycache__"))
        for words in (["--list"], ["paper", "--list"], ["full", "--scene", "trex", "--list"], ["--print-commands"]):
            command = [sys.executable, "-B", str(scripts / "benchmark.py"), *words]
            done = subprocess.run(command, capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(str(scripts.parent / "build"), done.stderr)
            self.assertIn("trex", done.stdout)
            self.assertNotIn("left out", done.stdout)
        for words in ([], ["--list", "--bench", str(self.folder / "none")]):
            command = [sys.executable, "-B", str(scripts / "benchmark.py"), *words]
            done = subprocess.run(command, capture_output=True, text=True, timeout=60)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), words)
            self.assertRegex(done.stderr, "(/none|cbvh_bench): .*program")

    def cage(self, faces):
        path = self.folder / f"own_{faces}.obj"
        path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" + "f 1 2 3 4\n" * faces)
        return str(path)

    def test_own_cage_has_default_and_chosen_levels(self):
        for words, levels in (([], "4,5"), (["--level", "3"], "3"), (["--level", "6,2"], "2,6"), (["full"], "4,5,6")):
            done = self.run_script("--cage", self.cage(6), *words)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(self.calls(), [f"own_6.obj {levels}"])
            shutil.rmtree(self.output)
        for text in ("", "six", "-1", "9", "4,,5", "4.5"):
            done = self.run_script("--cage", self.cage(6), f"--level={text}")
            if text:
                self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), text)
                self.assertRegex(done.stderr, f"--level '{text}': .* 0 to 8")
        self.assertRegex(self.run_script("quick", "--level", "4").stderr, "--level .*--cage")

    def test_estimate_of_own_cage_depends_on_its_size(self):
        def seconds(*words):
            minutes, rest = re.search(r"jobs, about (\d+):(\d\d)", self.run_script("--list", *words).stdout).groups()
            return 60 * int(minutes) + int(rest)

        small, large = seconds("--cage", self.cage(6)), seconds("--cage", self.cage(20000))
        self.assertGreater(large, 3 * small)
        finer, coarser = (seconds("--cage", self.cage(20000), "--level", level) for level in "65")
        self.assertGreater(finer, 2 * coarser)

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

    def test_records_of_another_gpu_are_measured_again(self):
        self.run_script("gpu-quick", "--scene", "cube")
        self.calls()
        (self.folder / "device").write_text("Device Two, driver 1")
        again = self.run_script("gpu-quick", "--scene", "cube")
        self.assertRegex(again.stdout, r"gpu_cube_L4-5\.json: .*Device One, driver 1")
        self.assertEqual(self.calls(), ["cube 1 vulkan", "cube 4,5 vulkan"])

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

    def test_gpu_without_doubles_is_measured_without_cvert(self):
        self.set_mode("no float64")
        done = self.run_script("gpu-quick", "--scene", "cube")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout, "cVERT .*: the device has no shaderFloat64")
        command = json.loads((self.output / "gpu_cube_L4-5.json").read_text())["run"]["command"]
        self.assertNotIn("cvert", command)

    def test_jobs_that_exceed_gpu_memory_are_left_out(self):
        self.set_mode("small")
        done = self.run_script("gpu-quick", "--scene", "cube")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout, r"gpu_cube +level 4-5 .*out of memory: nodes")

    def test_commands_are_printed_and_not_run(self):
        done = self.run_script("gpu", "--scene", "trex", "--print-commands")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.calls(), [])
        self.assertFalse(self.output.exists())
        lines = [shlex.split(line) for line in done.stdout.strip().split("\n") if not line.startswith("left out")]
        self.assertEqual(len(lines), 4)
        for words in lines:
            self.assertEqual(words[0], str(self.bench))
            self.assertIn("4,5,6,7", words)
            self.assertTrue(any("cleaf-only" in word or word == "naive" for word in words), "the paper's")
            self.assertNotIn("--pictures", words)
        self.assertEqual(["--device" in words for words in lines], [True, False, True, False])
        self.assertEqual(len({words[words.index("--json") + 1] for words in lines}), 4)

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
                done = subprocess.run(
                    [
                        BENCH,
                        "--scene",
                        job.scene,
                        "--level",
                        ",".join(map(str, job.levels)),
                        *words,
                        "--build-threads",
                        "-1",
                    ],
                    capture_output=True,
                    text=True,
                    timeout=60,
                )
                if "no Vulkan" in done.stderr and job.needs_vulkan:
                    continue
                self.assertRegex(done.stderr, r"\Acbvh_bench: .*--build-threads -1\b.*\n\Z", (name, job.name))


if __name__ == "__main__":
    unittest.main()
