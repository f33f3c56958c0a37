# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Figures 10 to 16 and 18 of the paper. Errors are the paper's RMSE, and values that it hides. The paper's cLEAF is
cLEAF-only here."""

from pathlib import Path

from . import figures as f
from .data import RAY_SETS
from .formats import Table, Title, mib, percent, pixels
from .memory import LABELS, LEVELS
from .relations import ratios

PAPER_SPEEDS = {"cGRID": (65, 84, 99), "cVOXEL": (73, 86, 105), "cLEAF-only": (69, 80, 92)}
LEVEL_COLORS = {4: "#4daf4a", 5: "#4682c8", 6: "#d9534f"}  # the paper's colors
PORTRAIT = ("GRID", "cVOXEL^3", "cLEAF-only^2")


def caption(row, grid, what):
    """Caption of a picture: memory of a shaded picture, and errors of all representations except for GRID."""
    texts = [f"{row.representation}, level {row.level}:"]
    if what == "picture":
        part = f", {percent(row.mib / grid.mib)} of GRID" if grid is not None else ""
        texts.append(f"{mib(row.memory_live_bytes)}{part}, {row.memory_bytes_per_quad:.2f} bytes per quad.")
    if row.kind != "GRID":
        rmse, median, p99 = (pixels(row[f"errors_{key}_pixels"]) for key in ("rmse", "median", "p99"))
        wrong = [percent(row[key] / max(1, row.errors_rays)) for key in ("errors_false_hits", "errors_misses")]
        texts.append(f"RMSE {rmse} px, median {median}, p99 {p99}; {row.errors_beyond_5_pixels:.0f} rays beyond 5 px;")
        texts.append(f"false hits {wrong[0]}, misses {wrong[1]}")
    return " ".join(texts)


def pictures(data, wanted, what):
    """Pictures, a line that lists missing pictures, and commands. wanted: (scene, level, representation, view); what:
    picture or error_map."""
    found, absent, commands = [], [], []
    for scene, level, label, view in wanted:
        row, name = data.pick(scene, level, label, view), f"{scene} in {label}, level {level}, {view} view"
        path = Path(row.folder) / "pictures" / row.job / Path(str(row[what])).name if row is not None else Path()
        if path.is_file():
            text = caption(row, data.pick(scene, level, "GRID", view), what)
            found.append(f.webp_picture(path, f"{what.replace('_', ' ')} of {name}", text))
            commands.append(row.command)
        else:
            absent.append(name)
    lines = [f"No data: {'; '.join(absent)}"] if absent and not data.is_own() else []
    return [found, *lines] if found else lines, commands


def figure_10(data):
    if data.is_own():  # also if the user's cage is named cube
        return [], []
    wanted = [("cube", 6, f"{kind}^{n}", "full") for kind in ("cVOXEL", "cLEAF-only") for n in (2, 3, 4)]
    return pictures(data, wanted, "error_map")


def figure_11(data):
    """The third picture shows the finest measured level; the paper's shows level 8."""
    main, level = data.paper_scene(), data.picture_level()
    fine = max([n for n in data.levels(main) if data.pick(main, n, "cVOXEL^4", "close") is not None] or [8])
    wanted = [(main, level, label, "close") for label in ("cVOXEL^3", "cLEAF-only^2")]
    return pictures(data, [*wanted, (main, fine, "cVOXEL^4", "close")], "error_map")


def portraits(data):
    """Figures 12 to 15 and 18, each after a title; for a user's cage, only the figures of the T-rex."""
    main, parts, commands = data.paper_scene(), [], []
    shown = [("12", main, "close", PORTRAIT), ("12, whole", main, "full", PORTRAIT), ("13", "frog", "close", PORTRAIT)]
    shown += [("14", "scythe", "close", PORTRAIT), ("15", "knee", "close", PORTRAIT)]
    shown += [("18, five-fold displacement", "cube:0.45", "full", ("GRID", "cVOXEL^3", "cLEAF-only^3"))]
    for number, scene, view, labels in shown:
        if scene == main or not data.is_own():
            found, made_by = pictures(data, [(scene, data.picture_level(), label, view) for label in labels], "picture")
            parts += [Title(f"Figure {number}: {scene}"), *found] if found else []
            commands += made_by
    return parts, commands


def bars(axes, title, rows):
    """Draws grouped bars of medians, with whiskers from the slowest to the fastest round."""
    labels, levels = [label for label in LABELS if label in set(rows.representation)], sorted(set(rows.level))
    width, style = 0.8 / len(levels), {"ecolor": f.INK, "elinewidth": 0.8, "capsize": 1.5}
    for k, level in enumerate(levels):
        found = rows[rows.level == level]
        xs = found.representation.map(labels.index) + (k - 0.5 * (len(levels) - 1)) * width
        middle, style_of_bar = found.mrays_per_second_median, {"color": LEVEL_COLORS[level], "label": f"level {level}"}
        ends = [middle - found.mrays_per_second_min, found.mrays_per_second_max - middle]
        axes.bar(xs, middle, 0.92 * width, yerr=ends, error_kw=style, **style_of_bar)
    names = [f.math_label(label) for label in labels]
    axes.set_xticks(range(len(names)), names, rotation=40, ha="right", rotation_mode="anchor")
    axes.grid(axis="x", visible=False)
    f.set_labels(axes, title, y="million rays per second, one thread")


def figure_16(data):
    main, rows, here = data.paper_scene(), [], data.here
    views = data.full[(data.full.scene == main) & data.full.level.isin(LEVELS) & data.full.representation.isin(LABELS)]
    single = (here.what == "speed") & (here["mode"] == "single") & (here.threads == 1) & (here["query"] == "closest")
    speeds = here[single & (here["view"] == "full") & here.result.isin(views.result)]
    found = [(rays, speeds[speeds["ray_set"] == rays]) for rays in RAY_SETS if (speeds["ray_set"] == rays).any()]
    charts = [f.chart(f"Speed, {rays} rays", 3.6, bars, f"{main}, {rays}", of_set) for rays, of_set in found]
    for kind in ("NAIVE", "NAIVE-compact", "cGRID", "cVOXEL", "cLEAF-only", "cVERT"):
        found, paper = ratios(data, kind, main), [f"{value}%" for value in PAPER_SPEEDS.get(kind, ())] or ["-"] * 3
        if len(found):
            rows.append([kind, *(f"{value:.0f}%" for value in (found.min(), found.mean(), found.max())), *paper])
    heads = ["relative to GRID", "min", "mean", "max", *(f"paper's T-rex: {name}" for name in ("min", "mean", "max"))]
    return [charts, Table(heads, rows)] if charts else [], speeds.command
