#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures a named set of scenes and representations with cbvh_bench.

    scripts/benchmark.py quick        the data for the first page of the report
    scripts/benchmark.py paper        all figures of the paper
    scripts/benchmark.py full         paper, packets, threads, instruction sets, large scenes, and gpu-quick
    scripts/benchmark.py gpu          speed and memory on a Vulkan device, and the same on one CPU thread
    scripts/benchmark.py gpu-quick    a shorter version of gpu for any device, including llvmpipe

--list prints what a set measures and about how long that takes on two idle cores.

Each job has its own record under output/benchmark/SET, which is rewritten after each level. If a run was stopped, the
same command continues with the first missing level. A record that is damaged or belongs to another build is measured
again; the old one is kept as *.json.old until then. scripts/report.py makes tables and plots of the records. Jobs that
require a Vulkan device are skipped with a message if there is none.
"""

import argparse
import fnmatch
import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bench_records as records  # noqa: E402
import benchmark_sets as sets  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent


class Failure(Exception):
    """An error with a message of one line for the user."""


def read_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n")[0],
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=__doc__.split("\n", 2)[2],
    )
    names = f"{', '.join(sets.NAMES[:-1])} or {sets.NAMES[-1]}"
    parser.add_argument("set", nargs="?", default="quick", metavar="SET", help=f"{names} (default: quick)")
    parser.add_argument(
        "--scene",
        type=lambda text: text.split(","),
        metavar="LIST",
        help="only jobs with a scene in this comma-separated list",
    )
    parser.add_argument(
        "--job",
        action="append",
        metavar="NAME",
        help="only this job, as --list names it, or a pattern such as 'frames_*'; may be repeated",
    )
    parser.add_argument("--cage", metavar="FILE", help="measure this OBJ instead of the set's scenes")
    parser.add_argument("--height", metavar="FILE", help="height map of the cage")
    parser.add_argument("--amplitude", metavar="A", help="displacement of the cage, in diagonals of its bounding box")
    parser.add_argument(
        "--level",
        metavar="LIST",
        help="comma-separated levels of the cage (default: 4,5 in the set quick, else 4,5,6)",
    )
    parser.add_argument(
        "--output", metavar="DIR", help="folder of the records (default: output/benchmark/SET, or the name of the cage)"
    )
    parser.add_argument(
        "--bench", metavar="PROGRAM", help="cbvh_bench (default: build/release/tutorials/bench/cbvh_bench)"
    )
    parser.add_argument(
        "--device",
        metavar="DEVICE",
        help="device of the sets gpu and gpu-quick: vulkan, followed by :N or :NAME to choose it by its index or a "
        "part of its name",
    )
    parser.add_argument("--fresh", action="store_true", help="measure all jobs, also those that have a record")
    parser.add_argument(
        "--list", action="store_true", help="print what the set measures and how long that takes, and exit"
    )
    parser.add_argument("--print-commands", action="store_true", help="print the command line of each job, and exit")
    return parser.parse_args()


def build_info(bench):
    """Returns the program's own description of its build."""
    if not bench.is_file():
        raise Failure(f"{bench}: no such program; build it first: cmake --build build/release")
    try:
        answer = subprocess.run([bench, "--about"], capture_output=True, text=True, timeout=60, check=True)
        return json.loads(answer.stdout)
    except (OSError, subprocess.SubprocessError, ValueError) as error:
        raise Failure(f"{bench}: does not answer --about: {type(error).__name__}") from error


def base_name(scene):
    return scene.split(":")[0]


def matches(job, name):
    """True if a job has this name or matches this pattern, such as frames_*."""
    return fnmatch.fnmatchcase(job.name, name)


MAX_LEVEL = 8


def levels_of(text):
    """Returns the levels of --level in ascending order."""
    try:
        levels = sorted({int(word) for word in text.split(",")})
    except ValueError:
        levels = []
    if not levels or levels[0] < 0 or levels[-1] > MAX_LEVEL:
        raise Failure(f"--level '{text}': expected levels from 0 to {MAX_LEVEL} with commas between them, as in 4,5,6")
    return levels


def faces_of(path):
    """Approximate number of quads of a cage at level 0: a face with n corners, n != 4, becomes n quads of a quarter
    face each."""
    count = 0
    with open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            if line.startswith("f "):
                corners = len(line.split()) - 1
                count += 1 if corners == 4 else corners / 4
    return count


def choose_jobs(options, build):
    """Returns the jobs of the command line. Prints a line for each job that this build does not support."""
    if options.set not in sets.NAMES:
        raise Failure(f"unknown set '{options.set}': expected one of {', '.join(sets.NAMES)}")
    if options.cage:
        for path in filter(None, (options.cage, options.height)):
            if not Path(path).is_file():
                raise Failure(f"{path}: no such file")
        words = ["--cage", options.cage]
        for name in ("height", "amplitude"):
            words += ["--" + name, getattr(options, name)] if getattr(options, name) else []
        levels = levels_of(options.level) if options.level else [4, 5] if options.set == "quick" else [4, 5, 6]
        return [sets.own_cage(Path(options.cage).stem, shlex.join(words), levels, faces_of(options.cage))]
    for name in ("height", "amplitude", "level"):
        if getattr(options, name):
            raise Failure(f"--{name} needs --cage: the scenes of a set have their own")
    jobs = sets.jobs_of(options.set, build["isas"])
    for name in options.scene or []:
        if name not in build["scenes"]:
            raise Failure(f"unknown scene '{name}': expected some of {', '.join(build['scenes'])}")
        if not any(base_name(job.scene) == name for job in jobs):
            raise Failure(f"scene '{name}' is not in the set '{options.set}'")
    for name in options.job or []:
        if not any(matches(job, name) for job in jobs):
            raise Failure(
                f"job '{name}' is not in the set '{options.set}': expected some of"
                f" {', '.join(job.name for job in jobs)}"
            )
    if options.scene:
        jobs = [job for job in jobs if base_name(job.scene) in options.scene]
    if options.job:
        jobs = [job for job in jobs if any(matches(job, name) for name in options.job)]
    for job in jobs:
        if base_name(job.scene) not in build["scenes"]:
            print(f"left out: {job.name} ({job.figures}), as this build has no scene '{base_name(job.scene)}'")
    jobs = [job for job in jobs if base_name(job.scene) in build["scenes"]]
    if options.device:
        if options.device.split(":")[0] != "vulkan":
            raise Failure(f"unknown --device '{options.device}': expected vulkan, vulkan:N or vulkan:NAME")
        if not any(job.needs_vulkan for job in jobs):
            raise Failure(f"--device: nothing of the set '{options.set}' needs a Vulkan device")
        for job in jobs:
            job.options = job.options.replace("--device vulkan", "--device " + shlex.quote(options.device))
    return jobs


def probe(bench, representation, device_option):
    """Opens a Vulkan device and traces a representation. Returns the device's name and "", or "" and the
    error message."""
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "probe.json"
        words = ["--scene", "cube", "--level", "1", "--representation", representation, "--device", device_option]
        words += ["--repeat", "0", "--size", "16x16", "--true-surface", "0"]
        words += ["--map-folder", folder, "--json", str(record)]
        try:
            done = subprocess.run([bench, *words], capture_output=True, text=True, timeout=300)
        except subprocess.TimeoutExpired:
            return "", "it did not answer in five minutes"
        if done.returncode:
            lines = done.stderr.strip().split("\n")
            return "", lines[-1].removeprefix("cbvh_bench: ") or f"the program ended with status {done.returncode}"
        return records.read(record)["groups"][0]["results"][0]["on_device"]["device"], ""


def supported_jobs(jobs, bench, named):
    """Returns the jobs that the Vulkan device supports, and its name. named: the value of --device, if
    any."""
    vulkan_jobs = [job.name for job in jobs if job.needs_vulkan]
    if not vulkan_jobs:
        return jobs, ""
    device_option = named or "vulkan"
    device, problem = probe(bench, "cvert", device_option)
    if "shaderFloat64" in problem:
        print(f"left out: cVERT on the Vulkan device: {problem}")
        device, problem = probe(bench, "grid", device_option)
        for job in jobs:
            if job.needs_vulkan:
                job.options = job.options.replace(",cvert", "")
    if device:
        return jobs, device
    if named:
        raise Failure(f"--device {named}: {problem}")
    print(f"left out: {', '.join(vulkan_jobs)}, as there is no Vulkan device: {problem}")
    return [job for job in jobs if not job.needs_vulkan], ""


def unwritten_levels(path, levels):
    """Returns the levels that a process which ended early has not written."""
    try:
        written = [group["level"] for group in records.read(path)["groups"]]
    except records.Damaged:
        written = []
    return [level for level in levels if level not in written]


def level_text(levels):
    return "-".join(str(level) for level in levels)


def devices_of(record):
    """Returns the names of the Vulkan devices in a record."""
    results = [result for group in record["groups"] for result in group["results"]]
    return {result["on_device"]["device"] for result in results if "on_device" in result}


def reason_to_repeat(record, job, build, device):
    """Returns the reason why a record must be measured again, or ""."""
    if record["run"]["commit"] != build["commit"] or not has_same_settings(job, record["run"]["command"]):
        return f"of commit {record['run']['commit']} or other settings"
    others = devices_of(record) - {device}
    return f"of the device {', '.join(sorted(others))}" if others else ""


def finished_levels(job, folder, build, device, fresh):
    """Returns the levels of a job for which complete records of the same build and settings exist."""
    done = set()
    for path in sorted(folder.glob(f"{job.name}_L*.json")):
        try:
            record = records.read(path)
            problem = reason_to_repeat(record, job, build, device)
        except records.Damaged as error:
            problem = str(error)
        if problem or fresh:
            path.replace(path.with_name(path.name + ".old"))  # kept until its replacement is complete
            if problem and not fresh:
                print(f"{path.name}: {problem}; measured again")
        else:
            done.update(group["level"] for group in record["groups"])
    return done


def has_same_settings(job, command):
    return all(word in command for word in job.arguments) and (not job.scene or f"--scene {job.scene} " in command)


def record_of(job, levels, folder):
    return folder / f"{job.name}_L{level_text(levels)}.json"


def command_of(bench, job, levels, folder):
    """Returns the command line of a job. Paths are relative, so that the record contains no folder of this machine."""
    command = [str(bench)] + (["--scene", job.scene] if job.scene else [])
    command += ["--level", ",".join(map(str, levels))] + job.arguments
    if job.pictures:  # a folder per job: jobs may show the same scene and view in different sizes
        command += ["--pictures", os.path.relpath(folder / "pictures" / job.name)]
    command += ["--json", os.path.relpath(record_of(job, levels, folder))]
    return command + ["--map-folder", os.path.relpath(folder / "maps")]  # jobs share trex's displacement map


def measure(command, log_path):
    """Runs one process. Returns its exit status and the last line that it wrote. An interrupt of this script is passed
    on: the process then ends after it has written its finished levels."""
    with open(log_path, "ab") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log, start_new_session=True)
        try:
            status = process.wait()
        except KeyboardInterrupt:
            process.send_signal(signal.SIGINT)
            process.wait()
            raise
    lines = log_path.read_text(encoding="utf-8", errors="replace").strip().split("\n")
    return status, lines[-1].strip()


def print_list(jobs, cage):
    for job in jobs:
        place = f"{job.scene or cage}, levels {level_text(job.levels)}"
        print(f"{job.name:18s} {job.figures:34s} {place}, about {clock(job.seconds)}")
    print(f"{len(jobs)} jobs, about {clock(sum(job.seconds for job in jobs))}, planned for two idle cores")


def clock(seconds):
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"


def run_job(job, levels, bench, folder):
    """Measures some levels of a job. Returns False if it failed."""
    print(f"  {job.name:18s} {job.figures}, level {level_text(levels)}", flush=True)
    status, message = measure(command_of(bench, job, levels, folder), folder / f"{job.name}.log")
    too_large = status and job.heavy and ("not enough memory" in message or "out of memory" in message)
    if too_large:
        missing = unwritten_levels(record_of(job, levels, folder), levels)
        print(f"  {job.name:18s} level {level_text(missing)} left out: {message.split(': ', 1)[-1]}")
    elif status:
        print(f"  {job.name:18s} failed with status {status}: {message}")
        if "cannot be written" in message:
            raise Failure(f"{folder}: {message}; results so far are kept, and the same command continues with the rest")
        return False
    for path in folder.glob(f"{job.name}_L*.json.old"):
        path.unlink()
    return True


def run(options):
    bench = Path(options.bench) if options.bench else ROOT / "build/release/tutorials/bench/cbvh_bench"
    if (options.list or options.print_commands) and not options.bench and not bench.is_file():
        print(f"no build yet at {bench}: the list may contain jobs that a build does not support", file=sys.stderr)
        build = {"scenes": sets.scenes_of(options.set) if options.set in sets.NAMES else [], "isas": list(sets.ISAS)}
    else:
        build = build_info(bench)
    jobs = choose_jobs(options, build)
    folder_name = options.output or f"output/benchmark/{Path(options.cage).stem if options.cage else options.set}"
    folder = Path(folder_name) if options.output else ROOT / folder_name
    if options.list:
        print_list(jobs, options.cage)
        return 0
    if options.print_commands:
        for job in jobs:
            print(shlex.join(command_of(bench, job, job.levels, folder)))
        return 0
    jobs, device = supported_jobs(jobs, bench, options.device)
    if not jobs:
        return 0
    folder.mkdir(parents=True, exist_ok=True)
    pending = []
    for job in jobs:
        done = finished_levels(job, folder, build, device, options.fresh)
        levels = [level for level in job.levels if level not in done]
        pending += [(job, levels)] if levels else []
    print(
        f"{options.set}: {len(jobs)} jobs, {len(jobs) - len(pending)} of them measured before; "
        f"{build['hardware_threads']} threads, commit {build['commit']}"
        + (f"; Vulkan device {device}" if device else ""),
        flush=True,
    )
    succeeded = [run_job(job, levels, bench, folder) for job, levels in pending]
    print(f"records in {folder_name}; tables and plots of them: scripts/report.py {folder_name}")
    return 0 if all(succeeded) else 1


def main():
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        return run(read_arguments())
    except KeyboardInterrupt:
        print("stopped; results so far are kept, and the same command continues with the rest")
        return 130
    except Failure as error:
        print(f"benchmark.py: {error}", file=sys.stderr)
    except OSError as error:
        print(f"benchmark.py: {error.filename or 'its output'}: {error.strerror}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
