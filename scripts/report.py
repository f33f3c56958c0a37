#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Writes what benchmark.py measured as a self-contained HTML page, as Markdown tables and as a CSV file of all records.

    scripts/report.py        reads output/benchmark/quick and writes report.html, tables.md and records.csv there
"""

import argparse
import sys
from pathlib import Path

import whole_file
from reporting import contents, records, scale, summary
from reporting.data import Data
from reporting.pages import render

ROOT = Path(__file__).resolve().parent.parent


def fail(path, problem):
    raise SystemExit(f"report.py: {path}: {problem}")


def write(path, text):
    """Writes a file completely or not at all."""
    try:
        whole_file.write(path, text)
    except OSError as error:
        fail(path, f"cannot be written: {error.strerror}")


def check_outputs(outputs, folders):
    """Rejects outputs that would overwrite an input record, or each other."""
    records_read = [file for path in folders for file in (path.glob("*.json") if path.is_dir() else [path])]
    for output in outputs:
        record = whole_file.would_replace(output, records_read)
        if record:
            fail(output, f"would replace the record {record.name}; give another name")
    if len({path.resolve() for path in outputs}) < len(outputs):
        fail(outputs[0], "is named by two of --output, --tables and --csv; give another name")


def read(folder, gpu=(), other_machines=()):
    """Returns the Data of the folders. Prints a warning for each record that cannot be used."""
    for path, hint in [(folder, "; scripts/benchmark.py makes it"), *((path, "") for path in other_machines)]:
        if not path.is_dir():
            fail(path, f"no such folder{hint}")
    for path in gpu:
        if not path.exists():
            fail(path, "no such file or folder; scripts/benchmark.py gpu-quick makes one")
    data = Data(folder, gpu, other_machines)
    if data.table.empty and not data.problems:
        fail(folder, "no measurements in it; scripts/benchmark.py makes them")
    for problem in data.problems:
        print(f"report.py: warning: {problem}; left out", file=sys.stderr)
    return data


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    default = ROOT / "output/benchmark/quick"
    parser.add_argument("folder", nargs="?", type=Path, default=default, metavar="DIR", help="records of benchmark.py")
    parser.add_argument("--output", type=Path, metavar="FILE", help="the page (default: report.html in DIR)")
    parser.add_argument("--tables", type=Path, metavar="FILE", help="Markdown (default: tables.md next to the page)")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="all records (default: records.csv next to the page)")
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
    page = options.output or options.folder / "report.html"
    tables, csv = options.tables or page.with_name("tables.md"), options.csv or page.with_name("records.csv")
    read_from = [options.folder, options.against, *options.gpu, *options.other_machine, options.scale]
    check_outputs((page, tables, csv), filter(None, read_from))
    scale_folder = options.scale or ROOT / "output/benchmark/scale"
    sections = contents.sections(data, against, options.folder.resolve().name, scale_folder)
    first, commands = summary.first_screen(data), data.table.command.drop_duplicates()
    evaluation, missing = "the evaluation of Lier, Martinek, Stamminger and Selgrad (2018)", data.missing_paper_scenes()
    subject = f"{evaluation}, made again by one command."
    if missing:
        subject = f"a part of {evaluation}. Not measured: {', '.join(missing)}."
    if data.is_own():
        subject = f"what they save and cost for {', '.join(data.scenes())}."
    write(page, render("page.html", sections=sections, first=first, subject=subject, csv=csv.name))
    write(tables, render("tables.md", sections=sections, first=first, commands=commands))
    write(csv, records.csv(data.table))
    size = f" ({page.stat().st_size / 2**20:.1f} MiB)" if page.is_file() else ""
    print(f"{page}{size}, {tables}, {csv}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
