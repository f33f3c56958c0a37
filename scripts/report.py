#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Makes one self-contained HTML page, and tables in Markdown, of what benchmark.py measured.

    scripts/report.py                              output/benchmark/quick to report.html and tables.md in it
    scripts/report.py DIR --output FILE            another folder of records, another page
    scripts/report.py DIR --against OTHER_DIR      says, too, how far two runs are apart
    scripts/report.py DIR --gpu FILE_OR_DIR        and speed and memory on a GPU, measured here or elsewhere
"""

import argparse
import os
import sys
from html import escape
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import report_bins  # noqa: E402
import report_data as d  # noqa: E402
import report_errors  # noqa: E402
import report_figures as f  # noqa: E402
import report_gpu as gpu  # noqa: E402
import report_hard_cases as hard_cases  # noqa: E402
import report_page as p  # noqa: E402
import report_sections as sections  # noqa: E402
import report_tables as tables  # noqa: E402
from report_relations import relations  # noqa: E402
from report_robustness import robustness  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent


def noise_text(data, against):
    found = d.noise(data.rows)
    if not found:
        return f"<p>No speeds were measured{' but those of the section on GPUs' if data.gpu else ''}.</p>"
    text = (
        "<p><b>Noise.</b> The middle half of the ratios to GRID of a combination spreads by "
        f"{100 * found['median']:.1f}% (median of {found['count']} combinations; the worst {100 * found['max']:.0f}%, "
        f"{found['beyond']} beyond 5%): {d.judged(found)}. By that, a median is good to {100 * found['unsure']:.1f}%, 95 of 100 "
        f"to {100 * found['unsure_95']:.1f}%, and ratios that are closer do not differ. One thread is timed by its "
        "processor time, so other programs cost caches and clock, not turns: that hits GRID, which has more to cache, "
        "harder, and may differ from run to run. How far a second run is apart, <code>--against</code> says. The spread "
        "of each ratio is in the last table.</p>"
    )
    if against is not None:
        apart = d.compare_runs(data, against)
        if apart:
            good = "less than 5%" if apart["beyond"] == 0 else f"{apart['beyond']} of them by more than 5%"
            text += (
                f"<p><b>Two runs.</b> Medians of ratios to GRID of {apart['count']} combinations differ by "
                f"{100 * apart['median']:.1f}% (median), 95 of 100 by less than {100 * apart['p95']:.1f}%, and at most "
                f"{100 * apart['max']:.1f}%: {good}.</p>"
            )
        else:
            text += "<p><b>Two runs.</b> They have no measurement in common.</p>"
    return text


def header(data, against, source):
    def several(values):
        return escape("; ".join(dict.fromkeys(values))) or "-"

    runs = data.runs
    loads = [run["load_before"] for run in runs]
    facts = [
        (
            "measured",
            several([f"{min(run['date'] for run in runs)} to {max(run['date'] for run in runs)}"] if runs else []),
        ),
        ("commit", several(run["commit"] for run in runs)),
        (
            "processor",
            several(
                f"{run['cpu']}, {run['hardware_threads']} threads, {run['memory_bytes'] / 2**30:.0f} GiB"
                for run in runs
            ),
        ),
        ("instruction set", escape(data.isa or "-")),
        ("compiler", several(f"{run['compiler']}, {run['build_type']} {run['flags']}" for run in runs)),
        ("load before", f"{min(loads):.1f} to {max(loads):.1f} runnable threads" if loads else "-"),
        ("records", f"{len(runs)} in <code>{escape(source)}</code>, made by <code>scripts/benchmark.py</code>"),
    ]
    text = "<dl>" + "".join(f"<dt>{name}</dt><dd>{value}</dd>" for name, value in facts) + "</dl>"
    text += "".join(f'<p class="missing">{escape(problem)}</p>' for problem in data.problems)
    return (
        "<p>Compressed subdivision surfaces in Embree: the evaluation of Lier, Martinek, Stamminger and Selgrad "
        "(2018), made again by one command.</p>" + text + noise_text(data, against)
    )


def make_page(data, against, source):
    table = relations(data)
    contents = {
        "relations": ("The paper's relations", tables.relation_section(table)),
        "figure10": ("Figure 10", sections.figure_10(data)),
        "figure11": ("11", sections.figure_11(data)),
        "pictures": ("12 to 15, 18", sections.figures_12_to_18(data)),
        "figure16": ("16", sections.figure_16(data)),
        "figure17": ("17", sections.figure_17(data)),
        "gpu": ("GPU", gpu.section(data)),
        "tradeoffs": ("Speed, memory and error", sections.tradeoffs(data)),
        "errors": ("Errors", report_errors.errors(data)),
        "bins": ("4 bits", report_bins.section(data)),
        "growth": ("Growth", sections.growth(data)),
        "entrances": ("Packets", tables.entrances(data)),
        "robustness": ("Leaks and shadows", robustness(data)),
        "hard": ("Hard cases", hard_cases.section(ROOT / "build/release/tests/hard_cases")),
        "all": ("All", tables.all_measurements(data)),
    }
    links = [(name, text) for name, (text, _) in contents.items()]
    title = "Embree CBVH: benchmark report"
    return p.page(title, header(data, against, source), [body for _, body in contents.values()], links)


def verdict(relation):
    return {True: "holds", False: "does not hold", None: "not measured"}[relation.holds]


def make_tables(data):
    """For the README: memory, error and speed of the main scene; the relations."""
    main = data.main_scene()
    lines = []
    for level in data.levels(main):
        rows = sorted((row for row in data.of_scene(main) if row.level == level), key=lambda row: f.sort_key(row.label))
        grid = data.pick(main, level, "GRID")
        lines += [
            f"{main}, level {level}, {rows[0].quads / 1e6:.2f} million quads",
            "",
            "| | bytes a quad | of GRID | build, s | RMSE, pixels | coherent, Mrays/s | of GRID "
            "| incoherent, Mrays/s | of GRID |",
            "|:--|--:|--:|--:|--:|--:|--:|--:|--:|",
        ]
        for row in rows:
            cells = [
                row.label,
                f"{row.memory['bytes_per_quad']:.2f}",
                f"{100 * row.bytes / grid.bytes:.0f}%" if grid else "-",
                f"{row.build_seconds:.2f}",
                f.error_text(row.errors("full")["rmse_pixels"]) if row.errors("full") else "-",
            ]
            for ray_set in ("coherent", "incoherent"):
                s = row.speed("full", ray_set)
                cells += (
                    [f"{s['mrays_per_second']['median']:.2f}", f"{100 * s['relative_to_grid']['median']:.0f}%"]
                    if s
                    else ["-", "-"]
                )
            lines.append("| " + " | ".join(cells) + " |")
        lines.append("")
    lines += ["| relation | paper | ours | |", "|:--|:--|:--|:--|"]
    for r in relations(data):
        lines.append(f"| {r.claim} | {r.paper} | {r.ours} | {verdict(r)}{': ' + r.reason if r.reason else ''} |")
    on_gpu = gpu.markdown(data)
    lines += ["", *on_gpu[:-1]] if on_gpu else []
    return "\n".join(lines) + "\n"


def write(path, text):
    """Whole or not at all."""
    temporary = path.with_name(f".tmp-{os.getpid()}-{path.name}")
    try:
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(path)
    except OSError as error:
        raise SystemExit(f"report.py: {path}: cannot be written: {error.strerror}") from error


def read(folder, gpu_paths=()):
    """gpu_paths: records and folders of them, for the section on GPUs alone."""
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
    options = parser.parse_args()
    data = read(options.folder, options.gpu)
    against = read(options.against) if options.against else None
    output = Path(options.output) if options.output else Path(options.folder) / "report.html"
    markdown = Path(options.tables) if options.tables else output.with_name("tables.md")
    write(output, make_page(data, against, Path(options.folder).name))
    write(markdown, make_tables(data))
    print(f"{output} ({output.stat().st_size / 2**20:.1f} MiB), {markdown}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
