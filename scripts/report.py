#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Writes what benchmark.py measured as tables in Markdown, as a plot for each scene and as a CSV file of all records.

    scripts/report.py        reads output/benchmark/quick and writes report.md, SCENE.svg and records.csv there
"""

import argparse
import sys
from pathlib import Path

import whole_file
from reporting import gpu, plot, records, relations, scale, tables
from reporting.data import Data

ROOT = Path(__file__).resolve().parent.parent
HARD_CASES = ROOT / "build/release/tests/hard_cases"


def fail(path, problem):
    raise SystemExit(f"report.py: {path}: {problem}")


def write(path, text):
    """Writes a file completely or not at all."""
    try:
        whole_file.write(path, text)
    except OSError as error:
        fail(path, f"cannot be written: {error.strerror}")


def read(folder, gpu=(), other_machines=()):
    """Returns the Data of the folders. Prints a warning for each record that cannot be used."""
    for path in (folder, *gpu, *other_machines):
        if not path.exists():
            fail(path, "no such file or folder; scripts/benchmark.py makes it")
    data = Data(folder, gpu, other_machines)
    if data.table.empty and not data.problems:
        fail(folder, "no measurements in it; scripts/benchmark.py makes them")
    for problem in data.problems:
        print(f"report.py: warning: {problem}; left out", file=sys.stderr)
    return data


def sections(data, against, scale_folder, folder):
    """Yields titles, contents, and what to measure for sections without contents."""
    if not data.is_own():
        yield "The paper's statements", relations.section(data), "scenes of the paper"
    for scene in data.scenes():
        name = scene.replace(":", "_") + ".svg"
        drawn = plot.write(folder / name, data.full[data.full.scene == scene], scene)
        yield scene, [
            *tables.of_scene(data, scene),
            *([f"![speed and memory over error]({name})"] if drawn else []),
        ], ""
    yield "Packets, streams and any hit", tables.entrances(data), "the job entrances of scripts/benchmark.py"
    yield "Instruction sets", tables.isas(data), "scripts/benchmark.py full --job isas, or --other-machine"
    yield "GPU", gpu.section(data), "scripts/benchmark.py gpu-quick, or --gpu"
    yield "Leaks, sheets and shadows", tables.checks(data), "jobs whose names begin with checks"
    yield "Hard cases", tables.hard_cases(HARD_CASES), "scripts/test.sh --all-isas -R 'hard_cases|invalid_vertices'"
    record = scale.read(scale_folder)
    yield "Scale", scale.tables(record) if record else [], "scripts/measure_scale.py"
    yield "Skipped", data.skipped("here"), ""
    yield "The run, and its noise", tables.run(data, against), ""
    yield "Commands", ["    " + command for command in data.table.command.drop_duplicates()], ""


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    default = ROOT / "output/benchmark/quick"
    parser.add_argument("folder", nargs="?", type=Path, default=default, metavar="DIR", help="records of benchmark.py")
    parser.add_argument("--output", type=Path, metavar="FILE", help="the report (default: report.md in DIR)")
    parser.add_argument("--against", type=Path, metavar="DIR", help="records of another run on the same machine")
    text = "record of a Vulkan device, or a folder of them; may be repeated"
    parser.add_argument("--gpu", type=Path, action="append", default=[], metavar="PATH", help=text)
    text = "records of another machine or instruction set, for their section; may be repeated"
    parser.add_argument("--other-machine", type=Path, action="append", default=[], metavar="DIR", help=text)
    text = "records of scripts/measure_scale.py (default: output/benchmark/scale, if it exists)"
    parser.add_argument("--scale", type=Path, metavar="DIR", help=text)
    return parser.parse_args()


def main():
    options = arguments()
    if options.scale and not scale.read(options.scale):
        fail(options.scale, f"no {scale.RECORD} in it; scripts/measure_scale.py makes it")
    data = read(options.folder, options.gpu, options.other_machine)
    against = read(options.against) if options.against else None
    report = options.output or options.folder / "report.md"
    if report.suffix != ".md":
        fail(report, "expected a name that ends in .md")
    lines = ["# Measurements", "", "<!-- Made by scripts/report.py of records of scripts/benchmark.py. -->", ""]
    for title, parts, missing in sections(
        data, against, options.scale or ROOT / "output/benchmark/scale", report.parent
    ):
        if parts or (missing and not data.is_own()):
            texts = [part if isinstance(part, str) else part.markdown() for part in parts]
            lines += [f"## {title}", "", *(f"{text}\n" for text in texts or [f"Not measured: {missing}"])]
    write(report, "\n".join(lines))
    write(report.with_name("records.csv"), records.csv(data.table))
    print(f"{report}, {report.with_name('records.csv')}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
