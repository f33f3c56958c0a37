#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures the tables of docs/performance.md and README.md in one run of cbvh_bench, and writes them into the pages.

    scripts/performance.py                  measures on the widest instruction set, some ten minutes
    scripts/performance.py --record FILE    uses a record of cbvh_bench --json, made with at least the options OPTIONS
                                            and --mode of measure() in this file

If the headline's figures change, change them in docs/figures.csv, too.
"""

import argparse
import re
import subprocess
import tempfile
import textwrap
from pathlib import Path

import bench_records as records
from benchmark import Failure, build_info
from reporting.formats import Table
from reporting.records import as_table, rows_of_record

ROOT = Path(__file__).resolve().parent.parent
PAGE, README = ROOT / "docs/performance.md", ROOT / "README.md"
TABLE, HEADLINE = "scripts/performance.py", "scripts/performance.py, headline"

SCENES, VIEWS = ("trex", "frog", "scythe", "knee", "cube"), ("full", "close")
# a large one, one that partly fits into the caches, and the smallest, which is the worst case
FRONT_SCENES = ("trex", "frog", "cube")
KINDS = ("cVERT", "cLEAF", "cVOXEL", "cGRID")
OPTIONS = (
    f"--scene {','.join(SCENES)} --level 6 --view {','.join(VIEWS)} --representation grid,cgrid,cvoxel,cleaf,cvert "
    "--frame-level auto --query closest,any --size 512x512 --true-surface 0 --repeat 9"
)
PACKETS = {"avx512": "packet16", "avx2": "packet8", "avx": "packet8", "sse4.2": "packet4", "sse2": "packet4"}

# Speeds relative to GRID's that the tables show: ray set, query, and whether rays are traced in packets.
COHERENT, INCOHERENT = ("coherent", "closest", False), ("incoherent", "closest", False)
ANY = (("coherent", "any", False), ("incoherent", "any", False))
PACKET = ("coherent", "closest", True)
COLUMNS = [("cVERT", (COHERENT, INCOHERENT)), ("- any hit", ANY), ("- packets", (PACKET,))]
COLUMNS += [(kind, (COHERENT, INCOHERENT)) for kind in KINDS[1:]]


def measure(bench):
    """Measures all scenes in one process and returns the record."""
    widest = build_info(bench)["isas"][-1]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "speeds.json"
        words = [bench, *OPTIONS.split(), "--isa", widest, "--mode", f"single,{PACKETS[widest]}", "--json", path]
        subprocess.run([str(word) for word in words], check=True)
        return records.read(path)


def rows_of(record):
    """Returns a record as a pandas table; if it has several libraries, only the last one's rows."""
    rows = rows_of_record(record, "")
    return as_table([row for row in rows if row.get("library") == rows[-1].get("library")])


def cell(rows, shown):
    """rows: one scene, kind and view."""
    ratios = []
    for ray_set, query, in_packets in shown:
        modes = rows.isa.map(PACKETS) if in_packets else "single"
        found = rows[
            (rows["ray_set"] == ray_set) & (rows["query"] == query) & (rows["mode"] == modes) & (rows.threads == 1)
        ]
        ratios.append(f"{found.relative_to_grid_median.iloc[0]:.2f}")
    return " ".join(ratios)


def lines_of(rows):
    first, out = rows.iloc[0], []
    for scene in SCENES:
        for view in VIEWS:
            cells, kind = [], ""
            for name, shown in COLUMNS:
                kind = kind if name.startswith("-") else name
                cells.append(cell(rows[(rows.scene == scene) & (rows.kind == kind) & (rows["view"] == view)], shown))
            out.append([f"{scene}, {view}", *cells])
    source = f"{first.run_cpu}, {first.isa.upper()}, {first.run_date[:10]}, commit {first.run_commit}."
    return [*Table(["", *(name for name, _ in COLUMNS)], out).markdown().split("\n"), source, ""]


def full_views(rows):
    """{(scene, kind): row} of full views."""
    rows = rows[rows["view"] == "full"].drop_duplicates(["scene", "kind"], keep="last")
    return {(row.scene, row.kind): row for _, row in rows.iterrows()}


def speeds_of_page():
    """Speeds of cVERT's single rays in docs/performance.md: (coherent, incoherent) by "scene, view"."""
    rows = re.findall(r"^\| (\w+, \w+) \| ([\d.]+) ([\d.]+) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    return {name: (coherent, incoherent) for name, coherent, incoherent in rows}


def front_table(rows):
    """GRID and cVERT in full views of three scenes."""
    heads = ["scene", "million quads", "MiB: GRID", "cVERT", "build, s: GRID", "cVERT", "coherent rays"]
    heads += ["incoherent rays", "error, pixels"]
    views, speeds, out = full_views(rows), speeds_of_page(), []
    for scene in FRONT_SCENES:
        pair = [views[scene, kind] for kind in ("GRID", "cVERT")]
        cells = [scene, f"{pair[0].quads / 1e6:.2f}", *(f"{row.memory_live_bytes / 2**20:.2f}" for row in pair)]
        cells += [f"{row.build_seconds:.3f}" for row in pair]
        out.append([*cells, *speeds[f"{scene}, full"], f"{pair[1].errors_p99_pixels:.3f}"])
    run = rows.iloc[0]
    source = (
        "Level 6 (64 x 64 quads per face; level 4: [5 to 8 times](docs/figures.md#memory-4) less memory), full views,"
        " 512 x 512 pixels. Error: 99th percentile of distances from GRID's hits. Memory, build"
        f" ({run.run_hardware_threads} threads), error: {run.run_cpu}, {run.run_date[:10]}, commit"
        f" {run.run_commit[:12]} (`scripts/performance.py`). [Ray speeds](docs/performance.md#how-fast-are-rays):"
        " multiples of GRID's, single rays, one thread."
    )
    return [
        *Table(heads, out).markdown().split("\n"),
        *textwrap.wrap(source, 116, break_long_words=False, break_on_hyphens=False),
        "",
    ]


def headline(rows):
    """The two headline ranges: memory over all scenes of the record, speed over all scenes and views of the page."""
    views, scenes = full_views(rows), sorted(set(rows.scene))
    smaller = [views[scene, "GRID"].memory_live_bytes / views[scene, "cVERT"].memory_live_bytes for scene in scenes]
    faster = [float(speed) for pair in speeds_of_page().values() for speed in pair]
    text = (
        f"**[{min(smaller):.0f} to {max(smaller):.0f} times](docs/figures.md#memory) less memory than Embree's own"
        f" subdivision surfaces; single rays at [{min(faster):.2f} to {max(faster):.2f} times](docs/figures.md#rays)"
        f" their speed**, lowest where the scene fits the caches ({len(scenes)} models,"
        " [level](docs/vocabulary.md#level) 6; [measurements](docs/performance.md#how-fast-are-rays))."
    )
    return [*textwrap.wrap(text, 116, break_long_words=False, break_on_hyphens=False), ""]


def write(page, name, lines):
    """Replaces the lines between the markers of a page."""
    begin, end = f"<!-- begin: {name} -->\n", "<!-- end -->\n"
    before, rest = page.read_text(encoding="utf-8").split(begin)
    after = rest.split(end, 1)[1]
    page.write_text(before + begin + "\n" + "\n".join(lines) + "\n" + end + after, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--bench",
        type=Path,
        default=ROOT / "build/release/tutorials/bench/cbvh_bench",
        metavar="PROGRAM",
        help="cbvh_bench (default: build/release/tutorials/bench/cbvh_bench)",
    )
    parser.add_argument("--record", metavar="FILE", help="use this record instead of measuring")
    parser.add_argument("--front-only", action="store_true", help="write only the table and the headline of README.md")
    options = parser.parse_args()
    try:
        rows = rows_of(records.read(options.record) if options.record else measure(options.bench))
    except records.Damaged as error:
        raise SystemExit(f"performance.py: {options.record}: {error}") from error
    except Failure as error:
        raise SystemExit(f"performance.py: {error}") from error
    if not options.front_only:
        write(PAGE, TABLE, lines_of(rows))
    write(README, TABLE, front_table(rows))
    write(README, HEADLINE, headline(rows))


if __name__ == "__main__":
    main()
