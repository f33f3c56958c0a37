#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures memory and time for a scene of ten billion quads on one machine, and the gain of view-dependent levels.

    scripts/measure_scale.py PATH/TO/cbvh_render FOLDER             both; 30 GB of disk, half an hour on two cores
    scripts/measure_scale.py PATH/TO/cbvh_render FOLDER --only levels

The herd is built copy by copy into FOLDER/herd.cbvh. The build is interrupted after a third, killed after two thirds,
and resumed each time. The file is then opened cold and warm, rendered, and traced for speed. GRID, NAIVE and
NAIVE-compact trace as many copies as fit into --memory, cVERT as many as GRID. The file is removed unless --keep is
given. Records and pictures go to FOLDER, tables to standard output. scripts/report.py --scale FOLDER includes them in
the report.
"""

import argparse
import datetime
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import whole_file  # noqa: E402
from measure_files import evict, mapping_of  # noqa: E402
from reporting import scale  # noqa: E402
from script_arguments import existing_program  # noqa: E402

GIB = 2**30
LEVELS = ("auto", "6", "7")
FILE_BYTES_PER_QUAD = 3  # estimated size of the file, to check the free disk space
# Peak bytes per quad during the build, for the largest herd of each representation; cVERT traces as many copies as
# GRID.
PEAK_BYTES_PER_QUAD = {"cvert": 40, "grid": 40, "naive": 260, "naive-compact": 200}


class Run:
    """A running program: its duration, peak anonymous memory and record."""

    def __init__(self, command, record=None, mapped=None):
        self.command = [str(word) for word in command] + (["--json", str(record)] if record else [])
        self.record, self.mapped, self.max_mapped, self.peak = record, mapped, 0, 0
        self.start = time.monotonic()
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True)
        self.watcher = threading.Thread(target=self.watch, daemon=True)
        self.watcher.start()

    def watch(self):
        """Samples the process's anonymous memory and its resident pages of the mapped file."""
        while self.process.poll() is None:
            try:
                status = Path(f"/proc/{self.process.pid}/status").read_text()
                self.peak = max(
                    [self.peak]
                    + [1024 * int(line.split()[1]) for line in status.split("\n") if line.startswith("RssAnon:")]
                )
            except (OSError, ValueError):
                pass
            if self.mapped:
                self.max_mapped = max(self.max_mapped, (mapping_of(self.process.pid, self.mapped) or {"Rss": 0})["Rss"])
            time.sleep(0.1)

    def finish(self, *, stopped=False):
        self.process.communicate()
        self.watcher.join()
        self.seconds = time.monotonic() - self.start
        if (self.process.returncode == 0) == stopped:
            raise SystemExit(f"{' '.join(self.command)}: {'ended before it was interrupted' if stopped else 'failed'}")
        return json.loads(Path(self.record).read_text()) if self.record else None


def interrupt_build(program, options, path, bytes_of_part, signal_number):
    """Builds the herd until the partial file has this size, then sends a signal."""
    run = Run([program, *options, "--save", path])
    part = Path(str(path) + ".part")
    while run.process.poll() is None and not (part.exists() and part.stat().st_size >= bytes_of_part):
        time.sleep(0.2)
    run.process.send_signal(signal_number)
    run.finish(stopped=True)
    return {"seconds": run.seconds, "bytes": part.stat().st_size, "signal": signal_number.name,
            "anonymous_bytes": run.peak}  # fmt: skip


def trace_in_memory(program, folder, kind, count, options):
    """Traces a number of copies in another representation, from memory."""
    run = Run([program, "--scene", "herd", "--count", count, "--level", options.level, "--representation", kind,
               "--speed", "--samples", 1, "--size", options.size, "--output", folder / kind],
              folder / f"{kind}.json")  # fmt: skip
    record = run.finish()
    (result,) = record["results"]
    return {"count": count, "representation": result["representation"], "quads": result["quads"],
            "bytes": result["live_bytes"], "peak_bytes": result["peak_bytes"], "build_seconds": result["build_seconds"],
            "speed": result["speed"], "command": " ".join(run.command)}  # fmt: skip


def from_file(program, folder, count, options):
    """Traces a number of copies of cVERT from a file, in the same view as the copies in memory."""
    path = folder / "from_file.cbvh"
    path.unlink(missing_ok=True)
    run = Run([program, "--scene", "herd", "--count", count, "--level", options.level, "--representation", "cvert",
               "--speed", "--samples", 1, "--size", options.size, "--output", folder / "from_file", "--save", path],
              folder / "from_file.json")  # fmt: skip
    record = run.finish()
    path.unlink()
    return {"count": count, "quads": record["quads"], "bytes": record["live_bytes"], "file_bytes": record["bytes"],
            "speed": record["speed"], "command": " ".join(run.command)}  # fmt: skip


def quads_of_a_copy(program, folder, level):
    run = Run([program, "--scene", "herd", "--count", 1, "--level", level, "--representation", "cvert", "--samples", 1,
               "--size", "64x64",
               "--output", folder / "one"], folder / "one.json")  # fmt: skip
    (result,) = run.finish()["results"]
    return result["quads"]


def measure_herd(program, folder, options):
    path = folder / "herd.cbvh"
    quads_per_copy = quads_of_a_copy(program, folder, options.level)
    count = options.count or -(-options.quads // quads_per_copy)
    free = os.statvfs(folder).f_bavail * os.statvfs(folder).f_frsize
    if free < FILE_BYTES_PER_QUAD * count * quads_per_copy:
        raise SystemExit(
            f"{folder}: {free / GIB:.0f} GiB are free, but the file needs about"
            f" {FILE_BYTES_PER_QUAD * count * quads_per_copy / GIB:.0f} GiB: expected another folder or fewer --quads"
        )
    scene = ["--scene", "herd", "--count", count, "--level", options.level, "--representation", "cvert"]
    build_options = [*scene, "--size", "64x64", "--samples", 1, "--output", folder / "build"]
    for leftover in (path, Path(str(path) + ".part")):
        leftover.unlink(missing_ok=True)
    expected = 2.8 * count * quads_per_copy
    stops = [
        interrupt_build(program, build_options, path, expected / 3, signal.SIGINT),
        interrupt_build(program, build_options, path, expected * 2 / 3, signal.SIGKILL),
    ]
    build = Run([program, *build_options, "--save", path], folder / "build.json")
    build_record = build.finish()
    view = ["--load", path, "--size", options.size, "--view", options.view]
    evict(path)
    cold = Run(
        [program, *view, "--output", folder / "picture", "--samples", options.samples], folder / "cold.json", path
    )
    cold_record = cold.finish()
    warm = Run([program, *view, "--output", folder / "warm", "--samples", 1, "--speed"], folder / "warm.json")
    warm_record = warm.finish()
    (picture,) = (folder / "picture").glob("*.png")
    record = {
        "count": count, "level": options.level, "quads": warm_record["quads"], "file_bytes": path.stat().st_size,
        "stops": stops, "resumed_geometries": build_record["resumed_geometries"],
        "last_quads": build_record["built_quads"],
        "last_seconds": build_record["build_seconds"],
        "device_bytes": build_record["build_peak_bytes"],
        "build_seconds": sum(s["seconds"] for s in stops) + build_record["build_seconds"],
        "anonymous_bytes": max(s["anonymous_bytes"] for s in stops),
        "cold": cold_record, "cold_mapped_bytes": cold.max_mapped, "warm": warm_record,
        "render_anonymous_bytes": max(cold.peak, warm.peak),
        "size": options.size, "samples": options.samples, "picture": picture.name, "threads": os.cpu_count(),
        "memory": options.memory * GIB, "commands": [" ".join(run.command) for run in (build, cold, warm)],
    }  # fmt: skip
    record["from_file"] = from_file(
        program, folder, max(1, int(options.memory * GIB / (PEAK_BYTES_PER_QUAD["cvert"] * quads_per_copy))), options
    )
    if not options.keep:
        path.unlink()
    counts = {
        kind: max(1, int(options.memory * GIB / (bytes_per_quad * quads_per_copy)))
        for kind, bytes_per_quad in PEAK_BYTES_PER_QUAD.items()
    }
    record["in_memory"] = [trace_in_memory(program, folder, kind, count, options) for kind, count in counts.items()]
    return record


def measure_levels(program, folder, options):
    rows = []
    for scene in options.scene.split(","):
        for view in ("full", "close"):
            for level in LEVELS:
                run = Run([program, "--scene", scene, "--level", level, "--view", view, "--representation", "cvert",
                           "--size", options.size, "--samples", 1, "--speed", "--true-surface", 20000,
                           "--output", folder / f"{scene}-{view}-{level}"],
                          folder / f"{scene}-{view}-{level}.json")  # fmt: skip
                (result,) = run.finish()["results"]
                place = {"scene": scene, "view": view, "level": level, "size": options.size}
                rows.append({**place, "command": " ".join(run.command), **result})
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=existing_program, help="cbvh_render")
    parser.add_argument("folder", type=Path, help="folder of the herd's file, records and pictures")
    parser.add_argument("--only", choices=("herd", "levels"), help="measure only one of the two (default: both)")
    parser.add_argument(
        "--quads", type=int, default=10**10, metavar="N", help="smallest number of quads in the herd (default: 10^10)"
    )
    parser.add_argument("--count", type=int, metavar="N", help="number of copies in the herd, instead of --quads")
    parser.add_argument("--level", default="6", metavar="L", help="level of the herd (default: 6)")
    parser.add_argument("--size", default="1920x1080", metavar="WxH", help="size of pictures (default: 1920x1080)")
    parser.add_argument(
        "--samples", type=int, default=16, metavar="N", help="samples per pixel of the picture (default: 16)"
    )
    parser.add_argument(
        "--view",
        default="17,9,9,-30,-4,-6,40",
        metavar="VIEW",
        help="view of the herd: full, close, or eye, target and vertical field of view as ex,ey,ez,lx,ly,lz,fov",
    )
    parser.add_argument(
        "--memory",
        type=float,
        default=0.8 * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / GIB,
        metavar="GIB",
        help="memory that the builds of representations may use (default: 0.8 of the machine's memory)",
    )
    parser.add_argument(
        "--scene",
        default="trex,frog,knee",
        metavar="LIST",
        help="comma-separated list of scenes for the comparison of levels (default: trex,frog,knee)",
    )
    parser.add_argument("--keep", action="store_true", help="do not remove the herd's file")
    options = parser.parse_args()
    folder = options.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / scale.RECORD
    record = scale.read(folder) or {}
    record["date"] = datetime.date.today().isoformat()
    if options.only != "levels":
        record["herd"] = measure_herd(options.program, folder, options)
    if options.only != "herd":
        record["levels"] = measure_levels(options.program, folder, options)
    whole_file.write(path, json.dumps(record, indent=1) + "\n")
    for part in scale.tables(record):
        print(part if isinstance(part, str) else part.markdown(), end="\n\n")


if __name__ == "__main__":
    main()
