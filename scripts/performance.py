#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures the table of kernels/cbvh/PERFORMANCE.md, all of it in one run of cbvh_bench, and writes it there.

    scripts/performance.py [BENCH]      BENCH: build/release/tutorials/bench/cbvh_bench unless given
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import bench_records as records
from report_data import Row
from report_markdown import table

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "kernels/cbvh/PERFORMANCE.md"
BEGIN, END = "<!-- begin: scripts/performance.py -->\n", "<!-- end -->\n"

SCENES, VIEWS = ("trex", "frog", "knee", "cube"), ("full", "close")
KINDS = ("cVERT", "cLEAF", "cVOXEL", "cGRID")
OPTIONS = (
    f"--scene {','.join(SCENES)} --level 6 --view {','.join(VIEWS)} --representation grid,cgrid,cvoxel,cleaf,cvert "
    "--frame-level auto --query closest,any --size 512x512 --true-surface 0 --repeat 9"
)
PACKETS = {"avx512": "packet16", "avx2": "packet8", "avx": "packet8", "sse4.2": "packet4", "sse2": "packet4"}

# What of GRID's speed is shown: ray set, query, and whether packets trace.
COHERENT, INCOHERENT = ("coherent", "closest", False), ("incoherent", "closest", False)
ANY = (("coherent", "any", False), ("incoherent", "any", False))
TOGETHER = ("coherent", "closest", True)
COLUMNS = [("cVERT", (COHERENT, INCOHERENT)), ("- any hit", ANY), ("- packets", (TOGETHER,))]
COLUMNS += [(kind, (COHERENT, INCOHERENT)) for kind in KINDS[1:]]


def measure(bench, isas, packets):
    """The records of all scenes, in one process."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "speeds.json"
        words = [bench, *OPTIONS.split(), "--isa", ",".join(isas), "--mode", ",".join(["single", *packets]), "--json", path]
        subprocess.run([str(word) for word in words], check=True)
        record = records.read(path)
    return [Row(record, "", ROOT, group, result) for group in record["groups"] for result in group["results"]]


def cell(row, view, shown):
    ratios = []
    for ray_set, query, together in shown:
        speed = row.speed(view, ray_set, query, PACKETS[row.isa] if together else "single")
        ratios.append(f"{speed['relative_to_grid']['median']:.2f}")
    return " ".join(ratios)


def lines_of(rows):
    run = rows[0].run
    out = []
    for isa in dict.fromkeys(row.isa for row in rows):
        for scene in SCENES:
            kinds = {row.kind: row for row in rows if (row.isa, row.scene) == (isa, scene)}
            for view in VIEWS:
                cells, kind = [], ""
                for name, shown in COLUMNS:
                    kind = kind if name.startswith("-") else name
                    cells.append(cell(kinds[kind], view, shown))
                out.append([f"{isa.upper()} {scene}, {view}", *cells])
    source = f"{run['cpu']}, {run['date'][:10]}, commit {run['commit']}; `cbvh_bench {OPTIONS}`"
    return [*table(["", *(name for name, _ in COLUMNS)], out), source + "\n"]


def main():
    if "-h" in sys.argv or "--help" in sys.argv:
        print(__doc__.strip())
        return
    bench = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/tutorials/bench/cbvh_bench")
    flags = Path("/proc/cpuinfo").read_text(encoding="ascii")
    isas = ["avx512", "avx2"] if "avx512vl" in flags else ["avx2", "sse4.2"]
    rows = measure(bench, isas, dict.fromkeys(PACKETS[isa] for isa in isas))
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    after = rest.split(END)[1]
    PAGE.write_text(before + BEGIN + "\n" + "\n".join(lines_of(rows)) + "\n" + END + after, encoding="utf-8")


if __name__ == "__main__":
    main()
