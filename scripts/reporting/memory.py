# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Figure 17 of the paper: memory, as bars whose parts add up to all memory of the device after the commit."""

from . import figures as f
from .formats import digits, is_known, percent

LABELS = ("NAIVE", "NAIVE-compact", "GRID", "cGRID^2", "cGRID^3", "cVOXEL^2", "cVOXEL^3", "cLEAF-only^2")
LABELS += ("cLEAF-only^3", "cVERT")
LEVELS = (4, 5, 6)
COLUMNS = {"leaves": "leaf_bytes", "nodes of blocks": "compression_node_bytes", "frames": "compression_header_bytes"}
COLORS = {"leaves": "#9ec9e2", "nodes of blocks": f.BLUE, "frames": f.ORANGE, "tree above": "#5b6875"}


def parts(row):
    """Bytes of each part. Their sum is the row's live bytes."""
    found = {name: row[f"memory_{key}"] if is_known(row[f"memory_{key}"]) else 0 for name, key in COLUMNS.items()}
    return {**found, "tree above": row.memory_live_bytes - sum(found.values())}


def stack(axes, rows, title, unit, scale, texts):
    """Draws horizontal bars, from top to bottom. scale: maps bytes of a row to its unit; texts: labels at the ends of
    the bars."""
    widest = max(scale(row) * row.memory_live_bytes for row in rows)
    for i, (row, text) in enumerate(zip(rows, texts)):
        begin = 0.0
        for name, count in parts(row).items():
            axes.barh(i, scale(row) * count, 0.7, left=begin, color=COLORS[name], label=name if i == 0 else None)
            begin += scale(row) * count
        axes.text(begin + 0.01 * widest, i, text, va="center", fontsize=8.5)
    f.row_labels(axes, [row.representation for row in rows])
    axes.set_xlim(0, 1.3 * widest)
    f.set_labels(axes, title, unit, columns=2)


def section(data):
    """Charts of each level, for all representations and for those up to a quarter of GRID. Lines that list what was
    skipped."""
    levels, commands = [], []
    for level in LEVELS:
        rows, charts = [data.pick(data.paper_scene(), level, label) for label in LABELS], []
        grid = getattr(rows[LABELS.index("GRID")], "memory_live_bytes", None)
        rows = [row for row in rows if row is not None]
        small = [row for row in rows if grid and 4 * row.memory_live_bytes <= grid]
        for title, found in ((f"Level {level}", rows), (f"Level {level}, up to a quarter of GRID", small)):
            shares = [f", {percent(row.memory_live_bytes / grid)}" if grid else "" for row in found]
            texts = [digits(row.mib) + share for row, share in zip(found, shares)]
            arguments = (1.7 + 0.24 * len(found), stack, found, title, "MiB", lambda row: 2**-20, texts)
            charts += [f.chart(f"Memory, {title}", *arguments)] if found else []
        levels, commands = levels + [charts] * bool(charts), commands + [row.command for row in rows]
    return levels + data.skipped("here") if levels else [], commands
