#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures the tables of docs/performance.md and README.md, all of it in one run of cbvh_bench, and writes them there.

    scripts/performance.py                  on the widest instruction set, some ten minutes
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
PAGE, FRONT = ROOT / "docs/performance.md", ROOT / "README.md"
TABLE, HEADLINE = "scripts/performance.py", "scripts/performance.py, headline"

SCENES, VIEWS = ("trex", "frog", "scythe", "knee", "cube"), ("full", "close")
FRONT_SCENES = ("trex", "frog", "cube")  # a large one, one that fits into memory caches in part, the smallest, which is the worst
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


def speed(row, view, ray_set):
    return row.speed(view, ray_set)["mrays_per_second"]["median"]


def ratio(row, view, ray_set):
    return row.speed(view, ray_set)["relative_to_grid"]["median"]


def front_table(rows):
    """GRID beside cVERT in full views of three scenes."""
    heads = ["scene", "quads", "", "memory, MiB", "build, s", "coherent rays, M/s", "incoherent, M/s", "error, pixels"]
    out = []
    for scene in FRONT_SCENES:
        for row in (row for kind in ("GRID", "cVERT") for row in rows if (row.scene, row.kind) == (scene, kind)):
            is_grid = row.kind == "GRID"
            cells = [scene if is_grid else "", f"{row.quads / 1e6:.2f} M" if is_grid else "", row.kind]
            cells += [f"{row.bytes / 2**20:.1f}", f"{row.build_seconds:.2f}"]
            cells += [f"{speed(row, 'full', ray_set):.2f}" for ray_set in ("coherent", "incoherent")]
            out.append([*cells, "" if is_grid else f"{row.errors('full')['p99_pixels']:.3f}"])
    run, isa = rows[0].run, rows[0].isa
    source = (
        f"Level 6 (64 x 64 quads per face), single rays of one thread; builds use {run['hardware_threads']} threads. Error: 99 of "
        f"100 rays hit closer to\nGRID's hit. {run['cpu']}, {isa.upper()}, {run['date'][:10]}, commit {run['commit'][:12]}, "
        "`scripts/performance.py`."
    )
    return [*table(heads, out, 3), source, ""]


def headline(rows):
    """The two ranges that matter, over all scenes and views."""
    by = {(row.scene, row.kind): row for row in rows}
    smaller = [by[scene, "GRID"].bytes / by[scene, "cVERT"].bytes for scene in SCENES]
    faster = [ratio(by[scene, "cVERT"], view, rays) for scene in SCENES for view in VIEWS for rays in ("coherent", "incoherent")]
    return [
        f"**{min(smaller):.0f} to {max(smaller):.0f} times less memory than Embree's subdivision surfaces; single rays at "
        f"{min(faster):.1f} to {max(faster):.1f} times their\nspeed** ({len(SCENES)} models, full and close views; "
        "[measurements](docs/performance.md#how-fast-are-rays)).",
        "",
    ]


def write(page, name, lines):
    """Puts lines between the markers of a page."""
    begin, end = f"<!-- begin: {name} -->\n", "<!-- end -->\n"
    before, rest = page.read_text(encoding="utf-8").split(begin)
    after = rest.split(end, 1)[1]
    page.write_text(before + begin + "\n" + "\n".join(lines) + "\n" + end + after, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bench", type=Path, default=ROOT / "build/release/tutorials/bench/cbvh_bench", help="the program that measures")
    parser.add_argument("--record", metavar="FILE")
    options = parser.parse_args()
    rows = rows_of(records.read(options.record) if options.record else measured(options.bench))
    write(PAGE, TABLE, lines_of(rows))
    write(FRONT, TABLE, front_table(rows))
    write(FRONT, HEADLINE, headline(rows))


if __name__ == "__main__":
    main()
