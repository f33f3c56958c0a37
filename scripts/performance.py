#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures the table of docs/performance.md, all of it in one run of cbvh_bench, and writes it there.

    scripts/performance.py                  on the widest instruction set, some six minutes
    scripts/performance.py --record FILE    from what cbvh_bench --json wrote, with those options at least
"""

import argparse
import subprocess
import tempfile
from pathlib import Path

import bench_records as records
from benchmark import about
from report_data import Row
from report_markdown import table

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/performance.md"
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


def measured(bench):
    """The record of all scenes, in one process."""
    widest = about(bench)["isas"][-1]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "speeds.json"
        words = [bench, *OPTIONS.split(), "--isa", widest, "--mode", f"single,{PACKETS[widest]}", "--json", path]
        subprocess.run([str(word) for word in words], check=True)
        return records.read(path)


def rows_of(record):
    """Of several libraries the last one's."""
    rows = [(result.get("library"), Row(record, "", ROOT, group, result)) for group in record["groups"] for result in group["results"]]
    return [row for library, row in rows if library == rows[-1][0]]


def cell(row, view, shown):
    ratios = []
    for ray_set, query, together in shown:
        speed = row.speed(view, ray_set, query, PACKETS[row.isa] if together else "single")
        ratios.append(f"{speed['relative_to_grid']['median']:.2f}")
    return " ".join(ratios)


def lines_of(rows):
    run, isa = rows[0].run, rows[0].isa
    out = []
    for scene in SCENES:
        kinds = {row.kind: row for row in rows if row.scene == scene}
        for view in VIEWS:
            cells, kind = [], ""
            for name, shown in COLUMNS:
                kind = kind if name.startswith("-") else name
                cells.append(cell(kinds[kind], view, shown))
            out.append([f"{scene}, {view}", *cells])
    source = f"{run['cpu']}, {isa.upper()}, {run['date'][:10]}, commit {run['commit']}."
    return [*table(["", *(name for name, _ in COLUMNS)], out), source, ""]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bench", type=Path, default=ROOT / "build/release/tutorials/bench/cbvh_bench", help="the program that measures")
    parser.add_argument("--record", metavar="FILE")
    options = parser.parse_args()
    rows = rows_of(records.read(options.record) if options.record else measured(options.bench))
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    after = rest.split(END)[1]
    PAGE.write_text(before + BEGIN + "\n" + "\n".join(lines_of(rows)) + "\n" + END + after, encoding="utf-8")


if __name__ == "__main__":
    main()
