#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures the table of files in docs/measurements.md: time and memory for opening a saved scene.

    scripts/measure_files.py PATH/TO/cbvh_render FOLDER [--repeat N]

Saves the scene to the folder first if the file does not exist. No page of a cold file is in memory: the file is flushed
to the disk and evicted from the page cache (posix_fadvise). Memory is the memory of the file's mapping in each process
(/proc/PID/smaps).
"""

import argparse
import json
import os
import statistics
import subprocess
import time
from pathlib import Path

from script_arguments import existing_program

VIEWS = {"all of it": ("full", "512x512"), "one claw": ("0.55,0.2,0.9,0.35,0.05,0.5,6", "768x768")}


def evict(path):
    with open(path, "rb") as file:
        os.fsync(file.fileno())
        os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)


def mapping_of(pid, path):
    """Rss and Pss of a mapped file in a process, in bytes; None if no page is resident."""
    sums = {"Rss": 0, "Pss": 0}
    inside = False
    try:
        for line in Path(f"/proc/{pid}/smaps").read_text().split("\n"):
            words = line.split()
            if len(words) > 1 and "-" in words[0] and not words[0].endswith(":"):
                inside = line.endswith(str(path))
            elif inside and words and words[0].rstrip(":") in sums:
                sums[words[0].rstrip(":")] += 1024 * int(words[1])
    except (OSError, ProcessLookupError):
        return None
    return sums if sums["Rss"] else None


def cached(path):
    command = ["fincore", "--bytes", "--noheadings", "--output", "RES", str(path)]
    return int(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def load(program, path, folder, processes, view):
    """Starts several processes at once. Returns their records, and their mappings at the last moment when all of them
    ran."""
    runs = []
    for i in range(processes):
        record = folder / f"load-{i}.json"
        command = [program, "--load", path, "--view", VIEWS[view][0], "--size", VIEWS[view][1], "--samples", "4"]
        command += ["--threads", "1", "--output", folder / f"load-{i}", "--json", record]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        runs.append((subprocess.Popen([str(word) for word in command], **quiet), record))
    mappings = [None] * processes
    while all(run.poll() is None for run, _ in runs):
        current = [mapping_of(run.pid, path) for run, _ in runs]
        if all(current):
            mappings = current
        time.sleep(0.01)
    for run, _ in runs:
        if run.wait() != 0:
            raise SystemExit(f"{program} --load {path} failed")
    return [json.loads(record.read_text()) for _, record in runs], mappings


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=existing_program, help="cbvh_render")
    parser.add_argument("folder", type=Path, help="folder of the saved scene")
    parser.add_argument("--scene", default="trex", metavar="NAME", help="generated scene (default: trex)")
    parser.add_argument(
        "--repeat", type=int, default=7, metavar="N", help="measurements, whose medians are printed (default: 7)"
    )
    options = parser.parse_args()
    folder = options.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{options.scene}.cbvh"
    if not path.exists():
        command = [options.program, "--scene", options.scene, "--level", "6", "--save", path, "--samples", "1"]
        subprocess.run([*command, "--output", folder / "save"], check=True, stdout=subprocess.DEVNULL)
    mib = 1 << 20
    print(f"{path.name}: {path.stat().st_size / mib:.1f} MiB\n")
    print(
        "| view | file | processes | open, ms | processor time, ms | first ray, ms | mapped, MiB | share, MiB | cached,"
        " MiB |"
    )
    print("|:--|:--|--:|--:|--:|--:|--:|--:|--:|")
    for view in VIEWS:
        for is_cold in (False, True):
            for processes in (1, 4):
                opened, processor_times, first, rss, pss, cached_bytes = [], [], [], [], [], []
                for _ in range(options.repeat):
                    if is_cold:
                        evict(path)
                    records, mappings = load(options.program, path, folder, processes, view)
                    opened += [r["open_seconds"] for r in records]
                    processor_times += [r["open_processor_seconds"] for r in records]
                    first += [r["first_ray_seconds"] for r in records]
                    rss += [s["Rss"] for s in mappings if s]
                    pss += [s["Pss"] for s in mappings if s]
                    cached_bytes.append(cached(path))
                middle = statistics.median
                print(
                    f"| {view} | {'cold' if is_cold else 'warm'} | {processes} | {1e3 * middle(opened):.1f} |"
                    f" {1e3 * middle(processor_times):.1f} | {1e3 * middle(first):.1f} | {middle(rss) / mib:.1f} |"
                    f" {middle(pss) / mib:.1f} | {middle(cached_bytes) / mib:.1f} |"
                    if rss
                    else "| the processes ended before their memory was read |"
                )


if __name__ == "__main__":
    main()
