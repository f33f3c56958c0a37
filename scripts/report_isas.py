# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on instruction sets: the same measured on each that processor and library have."""

from html import escape

import report_figures as f
import report_page as p
from report_data import ISAS

HEADS = ("Mrays/s", "of GRID")
RAY_SETS = ("coherent", "incoherent")
TEXT = (
    "<p>Single rays, closest hit, one thread, full view: millions of rays a second, and how many times GRID's on the same "
    "instruction set. All of them are measured in turns in one process.</p>"
)


def compared(data):
    """{(scene, level): {instruction set: {representation: row}}} of the jobs that measured several of them."""
    found = {}
    for row in data.rows:
        if row.speeds:
            found.setdefault((row.job, row.scene, row.level), {}).setdefault(row.isa, {})[row.label] = row
    return {(scene, level): isas for (_, scene, level), isas in sorted(found.items()) if len(isas) > 1}


def table(isas, ray_set):
    """Names of the instruction sets, and (representation, cells of each)."""
    names = [isa for isa in ISAS if isa in isas]
    labels = sorted({label for rows in isas.values() for label in rows}, key=f.sort_key)
    return names, [(label, [cell for isa in names for cell in cells(isas[isa].get(label), ray_set)]) for label in labels]


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
    return p.section(
        "isas",
        "Instruction sets",
        TEXT,
        body or p.missing("several instruction sets: scripts/benchmark.py full --job isas"),
        commands=commands,
    )
