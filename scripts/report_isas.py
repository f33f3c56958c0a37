# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on instruction sets: the same measured on each that processor and library have."""

import re
from html import escape

import report_data as d
import report_figures as f
import report_page as p
from report_data import ISAS

HEADS = ("Mrays/s", "of GRID")
RAY_SETS = ("coherent", "incoherent")
TEXT = (
    "<p>Single rays, closest hit, one thread, full view: millions of rays a second, and how many times GRID's on the same "
    "instruction set and machine.</p>"
)


def jobs_of(rows):
    """{(processor, scene, level): {job: its rows}} of what has speeds."""
    found = {}
    for row in rows:
        if row.speeds:
            found.setdefault((row.run["cpu"], row.scene, row.level), {}).setdefault(row.job, []).append(row)
    return found


def compared(data):
    """{(scene, level): {(instruction set, processor): {representation: row}}} where there are several of these. Of each
    processor it is the job that measured most of them, in turns in one process."""
    found = {}
    for (cpu, scene, level), jobs in sorted(jobs_of(data.rows + data.elsewhere).items()):
        rows = max(jobs.values(), key=lambda rows: (len({row.isa for row in rows}), len(rows)))
        for row in rows:
            found.setdefault((scene, level), {}).setdefault((row.isa, cpu), {})[row.label] = row
    return {key: columns for key, columns in found.items() if len(columns) > 1}


def table(columns, ray_set):
    """Names of the columns, and (representation, cells of each)."""
    keys = sorted(columns, key=lambda key: (ISAS.index(key[0]), key[1]))
    several = len({cpu for _, cpu in keys}) > 1
    labels = sorted({label for rows in columns.values() for label in rows}, key=f.sort_key)
    rows = [(label, [cell for key in keys for cell in cells(columns[key].get(label), ray_set)]) for label in labels]
    return [f"{isa}, {short(cpu)}" if several else isa for isa, cpu in keys], rows


def short(cpu):
    """A processor's name without what all names have."""
    return re.sub(r"\(R\)|\(TM\)| CPU| Processor(?= @|$)| @.*", "", cpu)


def machines(data):
    """A line a processor: which, when and what."""
    runs = {}
    for row in data.rows + data.elsewhere:
        runs.setdefault(row.run["cpu"], []).append(row.run)
    return [
        f"{cpu}: measured {d.period(of_cpu)}, commit "
        + ", ".join(sorted({run["commit"] for run in of_cpu}))
        for cpu, of_cpu in sorted(runs.items())
    ]


def cells(row, ray_set):
    found = row.speed("full", ray_set) if row else None
    if not found:
        return ["-"] * len(HEADS)
    return [f"{found['mrays_per_second']['median']:.2f}", f"{found['relative_to_grid']['median']:.2f}"]


def section(data):
    body, commands = "", []
    for (scene, level), isas in compared(data).items():
        for ray_set in RAY_SETS:
            names, rows = table(isas, ray_set)
            body += f"<h4>{escape(scene)}, level {level}, {ray_set}</h4>"
            body += p.grouped_table(names, HEADS, [(p.label(label), row) for label, row in rows])
        commands += [row.command for rows in isas.values() for row in rows.values()]
    lines = "".join(f'<p class="soft">{escape(line)}.</p>' for line in machines(data)) if data.elsewhere else ""
    return p.section(
        "isas",
        "Instruction sets",
        TEXT + lines,
        body or p.missing("several instruction sets: scripts/benchmark.py full --job isas, or records of another machine, scripts/report.py --beside"),
        commands=commands,
    )
