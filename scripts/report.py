#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Makes one self-contained HTML page, and tables in Markdown, of what benchmark.py measured.

    scripts/report.py                              output/benchmark/quick to report.html and tables.md in it
    scripts/report.py DIR --output FILE            another folder of records, another page
    scripts/report.py DIR --against OTHER_DIR      says, too, how far two runs are apart
    scripts/report.py DIR --gpu FILE_OR_DIR        and speed and memory on a GPU, measured here or elsewhere
    scripts/report.py DIR --beside OTHER_DIR       and speed on another machine or instruction set
    scripts/report.py DIR --scale OTHER_DIR        and the scene of ten billion quads, and levels by the view
    scripts/report.py DIR --tables FILE            the tables go there: tutorials/bench/RESULTS.md is made so
"""

import argparse
import sys
from html import escape
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import report_bins  # noqa: E402
import report_data as d  # noqa: E402
import report_errors  # noqa: E402
import report_gpu as gpu  # noqa: E402
import report_growth as growth  # noqa: E402
import report_hard_cases as hard_cases  # noqa: E402
import report_isas as isas  # noqa: E402
import report_levels as levels  # noqa: E402
import report_markdown as markdown  # noqa: E402
import report_memory as memory  # noqa: E402
import report_page as p  # noqa: E402
import report_paper as paper  # noqa: E402
import report_run  # noqa: E402
import report_scale as scale  # noqa: E402
import report_summary as summary  # noqa: E402
import report_tables as tables  # noqa: E402
import report_tradeoffs as tradeoffs  # noqa: E402
import whole_file  # noqa: E402
from report_relations import shown_relations  # noqa: E402
from report_robustness import robustness  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent


def without_empty(sections):
    return {name: entry for name, entry in sections.items() if not p.is_empty(entry[1])}


def make_page(data, against, source, scale_folder=None):
    """The result first, then what it was weighed against, then the paper; what few look for is at the end."""
    contents = {
        "Results": {
            "tradeoffs": ("Speed and memory against error", tradeoffs.section(data)),
            "levels": ("Levels and frame levels", levels.section(data)),
            "isas": ("Instruction sets", isas.section(data)),
            "gpu": ("GPU", gpu.section(data)),
            "errors": ("Errors", report_errors.errors(data)),
        },
        "The paper": {
            "relations": ("Its relations", tables.relation_section(shown_relations(data))),
            "figure10": ("Figure 10", paper.figure_10(data)),
            "figure11": ("Figure 11", paper.figure_11(data)),
            "pictures": ("Figures 12 to 15, 18", paper.figures_12_to_18(data)),
            "figure16": ("Figure 16: speed", paper.figure_16(data)),
            "figure17": ("Figure 17: memory", memory.section(data, paper.BARS)),
        },
        "More": {
            "bins": ("What 4 bits can give", report_bins.section(data)),
            "growth": ("Growth", growth.section(data)),
            "scale": ("Scale", scale.section(scale_folder)),
            "entrances": ("Packets and streams", tables.entrances(data)),
            "robustness": ("Leaks and shadows", robustness(data)),
            "hard": ("Hard cases", hard_cases.section(ROOT / "build/release/tests/hard_cases")),
            "all": ("All measurements", tables.all_measurements(data)),
            "run": ("The run, and its noise", report_run.section(data, against, source)),
        },
    }
    evaluation = "the evaluation of Lier, Martinek, Stamminger and Selgrad (2018), made again by one command."
    if data.is_own():
        evaluation = "what they save and cost for " + escape(", ".join(data.scenes())) + "."
        contents = {group: without_empty(sections) for group, sections in contents.items()}
    head = f'<p class="soft">Compressed subdivision surfaces in Embree: {evaluation}</p>' + summary.first_screen(data)
    return p.page("Embree CBVH: benchmark report", head, {group: found for group, found in contents.items() if found})


def write(path, text):
    """Whole or not at all."""
    try:
        whole_file.write(path, text)
    except OSError as error:
        raise SystemExit(f"report.py: {path}: cannot be written: {error.strerror}") from error


def check_outputs(outputs, folders):
    """Refuses to write over a record that is read, or two texts into one file."""
    records = []
    for folder in map(Path, folders):
        records += folder.glob("*.json") if folder.is_dir() else [folder]
    for output in outputs:
        record = whole_file.would_replace(output, records)
        if record:
            raise SystemExit(f"report.py: {output}: would replace the record {record.name}; give another name")
    if len({path.resolve() for path in outputs}) < len(outputs):
        raise SystemExit(f"report.py: {outputs[0]}: is the file of --output and of --tables; give another name")


def read(folder, gpu_paths=(), beside=()):
    """gpu_paths: records and folders of them, for the section on GPUs alone; beside: folders, for that on instruction
    sets alone."""
    if not Path(folder).is_dir():
        raise SystemExit(f"report.py: {folder}: no such folder; scripts/benchmark.py makes it")
    data = d.Data(folder)
    for path in gpu_paths:
        if not Path(path).exists():
            raise SystemExit(f"report.py: {path}: no such file or folder; scripts/benchmark.py gpu-quick makes one")
        before = len(data.gpu) + len(data.problems)
        data.add_gpu(path)
        if len(data.gpu) + len(data.problems) == before:
            data.problems.append(f"{Path(path).name}: nothing in it was measured on a Vulkan device")
    for other in beside:
        if not Path(other).is_dir():
            raise SystemExit(f"report.py: {other}: no such folder")
        before = len(data.elsewhere) + len(data.problems)
        data.add_elsewhere(other)
        if len(data.elsewhere) + len(data.problems) == before:
            data.problems.append(f"{Path(other).name}: nothing in it was measured on a processor")
    if not data.rows and not data.gpu and not data.problems:
        raise SystemExit(f"report.py: {folder}: no measurements in it; scripts/benchmark.py makes them")
    for problem in data.problems:
        print(f"report.py: warning: {problem}; left out", file=sys.stderr)
    return data


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument(
        "folder", nargs="?", default=str(ROOT / "output/benchmark/quick"), metavar="DIR", help="records of benchmark.py"
    )
    parser.add_argument("--output", metavar="FILE", help="the page (default: report.html in DIR)")
    parser.add_argument("--tables", metavar="FILE", help="tables in Markdown (default: tables.md beside the page)")
    parser.add_argument("--against", metavar="DIR", help="records of another run on the same machine")
    parser.add_argument(
        "--gpu", action="append", default=[], metavar="PATH",
        help="record of a Vulkan device, or a folder of them; may be repeated",
    )
    parser.add_argument(
        "--beside", action="append", default=[], metavar="DIR",
        help="records of another machine or instruction set, for their section; may be repeated",
    )
    parser.add_argument("--scale", metavar="DIR", help="what scripts/measure_scale.py measured (default: output/benchmark/scale, if it is there)")
    options = parser.parse_args()
    if options.scale and not scale.read(options.scale):
        raise SystemExit(f"report.py: {options.scale}: no {scale.RECORD} in it; scripts/measure_scale.py makes it")
    data = read(options.folder, options.gpu, options.beside)
    against = read(options.against) if options.against else None
    output = Path(options.output) if options.output else Path(options.folder) / "report.html"
    tables_file = Path(options.tables) if options.tables else output.with_name("tables.md")
    folders = [options.folder, options.against, *options.gpu, *options.beside, options.scale]
    check_outputs((output, tables_file), filter(None, folders))
    write(output, make_page(data, against, Path(options.folder).name, options.scale or ROOT / "output/benchmark/scale"))
    write(tables_file, markdown.results(data))
    size = f" ({output.stat().st_size / 2**20:.1f} MiB)" if output.is_file() else ""
    print(f"{output}{size}, {tables_file}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
