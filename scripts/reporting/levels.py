# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Bytes and speeds over levels, frame levels and instruction sets, and growth over the number of quads."""

import re

from . import figures as f
from .data import ISAS, RAY_SETS
from .formats import percent, pivoted

FALLBACK = "quads stored as cVERT"
GROWING = ("NAIVE", "NAIVE-compact", "GRID", "cGRID^2", "cVOXEL^2", "cLEAF^2", "cLEAF-only^2", "cVERT")
LINE_STYLES = {"solid": "-", "dashed": "--", "dotted": ":", "dash-dot": "-."}
CHARTS = {  # unit, column, whether its axis is logarithmic
    "Memory": ("MiB", "mib", True), "Build": ("seconds, all threads", "build_seconds", True),
    "Speed, incoherent rays": ("million rays per second, one thread", "incoherent", False),
}  # fmt: skip


def fallback_share(row):
    """Share of cLEAF's quads that are stored as cVERT; None for other representations."""
    return row.memory_compression_fallback_quads / max(1, row.memory_compression_quads) if row.kind == "cLEAF" else None


def speed(rays):
    """Returns a function that computes multiples of GRID's speed, and for GRID millions of rays per second."""
    return lambda row: row[rays] if row.kind == "GRID" else row[f"{rays}_of_grid"]


TABLES = {"bytes per quad": ("memory_bytes_per_quad", "{:.2f}"), FALLBACK: (fallback_share, percent)}
TABLES |= {f"speed, {rays} rays": (speed(rays), "{:.2f}") for rays in RAY_SETS}


def section(data):
    """Tables of scenes with several levels, or with several frame levels of one kind. Only cLEAF has a table of quads
    that are stored as cVERT."""
    parts, commands = [], []
    for scene in data.scenes():
        rows = data.full[data.full.scene == scene]
        if rows.level.nunique() > 1 or rows.groupby("kind").frame_level.nunique().max() > 1:
            frames = {title: rows[rows.kind == "cLEAF"] if title == FALLBACK else rows for title in TABLES}
            parts += [
                pivoted(frame, "level", [("", *TABLES[title])], "level {}".format, f"{scene}: {title}")
                for title, frame in frames.items() if len(frame)
            ]  # fmt: skip
            commands += list(rows.command)
    return parts, commands


def draw(axes, title, unit, column, is_log, rows):
    """Draws a line for each scene and representation."""
    scenes, labeled = dict(zip(sorted(set(rows.scene)), list(LINE_STYLES) * len(rows))), set()
    for (scene, label), found in rows.groupby(["scene", "representation"], sort=False):
        color, mark = f.KINDS[found.kind.iloc[0]]
        style = {"color": color, "marker": mark, "markersize": 4.5, "linestyle": LINE_STYLES[scenes[scene]]}
        axes.plot(found.quads, found[column], label=None if label in labeled else f.math_label(label), **style)
        labeled.add(label)
    f.log_axis(axes, "x")
    f.log_axis(axes, "y") if is_log else axes.set_ylim(bottom=0)
    f.set_labels(axes, title, f"quads ({', '.join(f'{scene}: {style}' for scene, style in scenes.items())})", unit)


def growth(data):
    charts, commands = [], []
    rows = data.full[data.full.representation.isin(GROWING)].sort_values("quads", kind="stable")
    for title, (unit, column, is_log) in CHARTS.items():
        found = rows[rows[column] > 0]
        found = found[found.groupby(["scene", "representation"])["level"].transform("count") > 1]
        if len(found):
            charts.append(f.chart(f"{title} over the number of quads", 3.9, draw, title, unit, column, is_log, found))
            commands += list(found.command)
    return [charts] if charts else [], commands


def by_instruction_set(data):
    """Frames by scene and level of measurements on several instruction sets or CPUs, of this and other machines. For
    each CPU they contain the job that measured the most instruction sets alternately in one process."""
    rows, keys = data.every_view, ["scene", "level", "run_cpu", "isa", "representation"]
    rows = rows[(rows.origin == "elsewhere") | rows.result.isin(data.here.result)]
    rows = rows[(rows["view"] == "full") & (rows["speeds"] > 0)]
    rows = rows.assign(isas=rows.groupby(["scene", "level", "run_cpu", "job"]).isa.transform("nunique"))
    rows = rows[rows.isas == rows.groupby(["scene", "level", "run_cpu"]).isas.transform("max")].drop_duplicates(keys)
    frames = {key: found for key, found in rows.groupby(["scene", "level"])}
    return {key: found for key, found in frames.items() if len(found[["isa", "run_cpu"]].drop_duplicates()) > 1}


def isa_table(rows, rays, title):
    """A table with columns for each instruction set, and for each CPU if there are several."""
    columns = [("Mrays/s", rays, "{:.2f}"), ("of GRID", f"{rays}_of_grid", "{:.2f}")]
    short, several = re.compile(r"\(R\)|\(TM\)| CPU| Processor(?= @|$)| @.*"), rows.run_cpu.nunique() > 1
    rows = rows.assign(column=list(zip(rows.isa.map(ISAS.index), rows.run_cpu)))
    return pivoted(
        rows, "column", columns, lambda key: ISAS[key[0]] + several * f", {short.sub('', key[1])}" + ": ", title
    )  # fmt: skip


def isas(data):
    """Tables, and a line for each CPU if there are records of other machines."""
    parts, commands, table = [], [], data.table
    for (scene, level), rows in by_instruction_set(data).items():
        parts += [isa_table(rows, rays, f"{scene}, level {level}, {rays}") for rays in RAY_SETS]
        commands += list(rows.command)
    for cpu, rows in table[table.origin.isin(("here", "elsewhere"))].groupby("run_cpu") if parts else ():
        if (table.origin == "elsewhere").any():
            times = f"measured {rows.run_date.min()} to {rows.run_end.fillna(rows.run_date).max()}"
            parts.append(f"{cpu}: {times}, commit {', '.join(sorted(set(rows.run_commit)))}.")
    return parts, commands
