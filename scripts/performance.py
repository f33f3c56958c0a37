#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures memory, builds, rays and errors of all scenes in one run of cbvh_bench, and writes the tables of
docs/measurements.md, the table and the headline of README.md, and the chart docs/memory.svg.

    scripts/performance.py                  measures on the widest instruction set: a quarter of an hour, 12 GiB
    scripts/performance.py --record FILE    uses a record that an earlier run left in output/performance.json
"""

import argparse
import json
import subprocess
import textwrap
from pathlib import Path

import bench_records as records
import memory_chart
from benchmark import Failure, build_info
from reporting.formats import Table
from reporting.records import as_table, rows_of_record

ROOT = Path(__file__).resolve().parent.parent
PAGE, README, CHART = ROOT / "docs/measurements.md", ROOT / "README.md", ROOT / "docs/memory.svg"
RECORD = ROOT / "output/performance.json"
NAME = "scripts/performance.py"

SCENES, VIEWS = ("trex", "frog", "scythe", "knee", "cube"), ("full", "close")
TRIANGLES, COMPACT, EMBREE, OURS, SMALL = "NAIVE", "NAIVE-compact", "GRID", "cTILE", "cVERT"
PAPER = ("cLEAF", "cVOXEL", "cGRID")
SHARED = f"--scene {','.join(SCENES)} --level 6 --frame-level auto --size 512x512 --true-surface 0"
# Embree's compact mode has the hits of its triangles, and only its memory is measured.
COMPACT_OPTIONS = f"{SHARED} --view full --representation naive-compact --repeat 0"
OPTIONS = (
    f"{SHARED} --view {','.join(VIEWS)} --representation naive,grid,cgrid,cvoxel,cleaf,cvert,ctile"
    " --query closest,any --repeat 9"
)
PACKETS = {"avx512": "packet16", "avx2": "packet8", "avx": "packet8", "sse4.2": "packet4", "sse2": "packet4"}

# Speeds: ray set, query, and whether rays are traced in packets.
COHERENT, INCOHERENT = ("coherent", "closest", False), ("incoherent", "closest", False)
ANY = (("coherent", "any", False), ("incoherent", "any", False))
SINGLE, PACKET = (COHERENT, INCOHERENT), (("coherent", "closest", True),)
COLUMNS = [(EMBREE, EMBREE, SINGLE), (OURS, OURS, SINGLE), ("- any hit", OURS, ANY), ("- packets", OURS, PACKET)]
COLUMNS += [(kind, kind, SINGLE) for kind in (SMALL, *PAPER)]


def run(bench, options, path):
    """Runs cbvh_bench and returns its record."""
    subprocess.run([str(word) for word in (bench, *options.split(), "--json", path)], check=True)
    return records.read(path)


def measure(bench):
    """Measures all scenes in one process, and Embree's compact mode in another. Returns the record of both."""
    RECORD.parent.mkdir(parents=True, exist_ok=True)
    widest = build_info(bench)["isas"][-1]
    record = run(bench, f"{OPTIONS} --isa {widest} --mode single,{PACKETS[widest]}", RECORD)
    record["groups"] += run(bench, f"{COMPACT_OPTIONS} --isa {widest}", RECORD.with_name("compact.json"))["groups"]
    RECORD.write_text(json.dumps(record), encoding="utf-8")
    return record


class Measured:
    """A record, by scene, representation and view."""

    def __init__(self, record):
        rows = as_table(rows_of_record(record, ""))
        self.run = rows.iloc[0]
        self.speeds = rows[(rows.what == "speed") & (rows.threads == 1)]
        built = rows[rows["view"] == "full"].drop_duplicates(["scene", "kind"], keep="first")
        self.built = {(row.scene, row.kind): row for _, row in built.iterrows()}

    def mebibytes(self, scene, kind):
        return self.built[scene, kind].memory_live_bytes / 2**20

    def bytes_per_quad(self, scene, kind):
        return self.built[scene, kind].memory_live_bytes / self.built[scene, EMBREE].quads

    def smaller(self, than, kind):
        """Returns the least and the largest factor by which a kind is smaller, of all scenes."""
        factors = [self.mebibytes(scene, than) / self.mebibytes(scene, kind) for scene in SCENES]
        return min(factors), max(factors)

    def speed(self, scene, view, kind, rays):
        """Returns the speed relative to triangles, as a ratio of medians."""
        ray_set, query, in_packets = rays
        rows = self.speeds[(self.speeds.scene == scene) & (self.speeds["view"] == view)]
        rows = rows[(rows["ray_set"] == ray_set) & (rows["query"] == query)]
        rows = rows[rows["mode"] == (PACKETS[self.run.isa] if in_packets else "single")].set_index("kind")
        return rows.mrays_per_second_median[kind] / rows.mrays_per_second_median[TRIANGLES]

    def speeds_in_words(self, scene, view, kind, rays):
        return " ".join(f"{self.speed(scene, view, kind, one):.2f}" for one in rays)

    def range_of_speeds(self, kind, rays):
        """Returns the least and the largest speed over all scenes and views, relative to triangles."""
        ratios = [self.speed(s, view, kind, one) for s in SCENES for view in VIEWS for one in rays]
        return f"{min(ratios):.2f} to {max(ratios):.2f}"

    def source(self):
        run = self.run
        return f"{run.run_cpu}, {run.isa.upper()}, {run.run_date[:10]}, commit {run.run_commit[:12]}"


def rounded(mebibytes):
    return f"{mebibytes:,.0f}" if mebibytes >= 10 else f"{mebibytes:.2f}"


def times(limits):
    return " to ".join(f"{limit:.0f}" for limit in limits)


def wrapped(text):
    return [*textwrap.wrap(text, 116, break_long_words=False, break_on_hyphens=False), ""]


def memory_table(measured):
    """Memory, builds and errors of the default view."""
    heads = ["scene", "million quads", "MiB: triangles", "compact", EMBREE, OURS, SMALL]
    heads += [f"bytes per quad: {OURS}", SMALL, "build, s: triangles", EMBREE, OURS, SMALL, "error, pixels"]
    out = []
    for scene in SCENES:
        cells = [scene, f"{measured.built[scene, EMBREE].quads / 1e6:.2f}"]
        cells += [rounded(measured.mebibytes(scene, kind)) for kind in (TRIANGLES, COMPACT, EMBREE, OURS, SMALL)]
        cells += [f"{measured.bytes_per_quad(scene, kind):.2f}" for kind in (OURS, SMALL)]
        cells += [f"{measured.built[scene, kind].build_seconds:.3f}" for kind in (TRIANGLES, EMBREE, OURS, SMALL)]
        out.append([*cells, f"{measured.built[scene, OURS].errors_p99_pixels:.3f}"])
    return [*Table(heads, out).markdown().split("\n"), *wrapped(f"{measured.source()}.")]


def speed_table(measured):
    heads = ["", *(name for name, _, _ in COLUMNS)]
    out = [
        [f"{scene}, {view}", *(measured.speeds_in_words(scene, view, kind, rays) for _, kind, rays in COLUMNS)]
        for scene in SCENES
        for view in VIEWS
    ]
    return [*Table(heads, out).markdown().split("\n"), *wrapped(f"{measured.source()}.")]


def front_table(measured):
    heads = ["model", "MiB: triangles", "subdivision", "**ours**", "smallest", "speed"]
    out = []
    for scene in SCENES:
        cells = [scene, *(rounded(measured.mebibytes(scene, kind)) for kind in (TRIANGLES, EMBREE, OURS, SMALL))]
        out.append([*cells, measured.speeds_in_words(scene, "full", OURS, SINGLE)])
    text = (
        "Ours is cTILE, the default; smallest is cVERT, with the same hits. Speeds of coherent (camera) and incoherent"
        " (bounced) rays are multiples of the triangles'."
        f" ({measured.source()}; `{NAME}`)"
    )
    return [*Table(heads, out).markdown().split("\n"), *wrapped(text)]


def headline(measured):
    triangles, subdivision = measured.smaller(TRIANGLES, OURS), measured.smaller(EMBREE, OURS)
    text = (
        f"**{times(triangles)} times less memory than Embree's triangles, {times(subdivision)} times less than its"
        f" subdivision surfaces, and single rays at {measured.range_of_speeds(OURS, SINGLE)} times the"
        f" triangles' speed** (shadow rays {measured.range_of_speeds(OURS, ANY)},"
        f" packets {measured.range_of_speeds(OURS, PACKET)})."
    )
    return wrapped(text)


def chart(measured):
    """Bars of bytes per quad, with the speed of rays in full views."""
    names = {TRIANGLES: "triangles", EMBREE: "subdivision", OURS: "Embree CBVH", SMALL: "its smallest form"}
    bars = []
    for scene in SCENES:
        rows = []
        for kind, name in names.items():
            speeds = [f"{measured.speed(scene, 'full', kind, rays):.2f}" for rays in SINGLE]
            label = f"{rounded(measured.mebibytes(scene, kind))} MiB, rays {speeds[0]} and {speeds[1]}"
            rows.append((name, measured.bytes_per_quad(scene, kind), label))
        bars.append((f"{scene}, {measured.built[scene, EMBREE].quads / 1e6:.2f} million quads", rows))
    return memory_chart.svg(
        "Bytes per quad; speed of coherent and incoherent rays as a multiple of the speed with triangles",
        bars,
        measured.source(),
    )


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
    options = parser.parse_args()
    try:
        measured = Measured(records.read(options.record) if options.record else measure(options.bench))
    except records.Damaged as error:
        raise SystemExit(f"performance.py: {options.record or RECORD}: {error}") from error
    except Failure as error:
        raise SystemExit(f"performance.py: {error}") from error
    write(PAGE, f"{NAME}, memory", memory_table(measured))
    write(PAGE, f"{NAME}, rays", speed_table(measured))
    write(README, NAME, front_table(measured))
    write(README, f"{NAME}, headline", headline(measured))
    CHART.write_text(chart(measured), encoding="utf-8")


if __name__ == "__main__":
    main()
