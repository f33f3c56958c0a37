# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on errors: compression alone, and with tessellation, side by side."""

from html import escape

import report_figures as f
import report_page as p

MESH_HEADS = ("", "level", "view", "median", "p99", "bias", "normal", "flipped", "(u,v)")
TRUE_HEADS = (
    "",
    "level",
    "view",
    "median",
    "p99",
    "bias",
    "normal",
    "(u,v)",
    "rules",
)

TEXT = (
    "<p>Two errors of each hit. Against the <b>mesh</b>, GRID's of the same level: what compression costs. Against the "
    "<b>true</b> surface, OpenSubdiv's limit surface displaced by the heights as they are in the map, on a random sample "
    "of the hits: what tessellation and compression cost together, GRID's own error included. Both are distances in pixels, "
    "to GRID's hit of the same ray and to the nearest point of the true surface: half of the hits stay below the median, 99 of "
    "100 below p99. The bias is along the ray, of hits within 5 pixels, and positive behind; normal and (u,v) are medians in "
    "degrees and in quads of the level; flipped counts normals that are more than 90 degrees from the mesh's. A ray that passes "
    "a silhouette in one of both hits another sheet, far from the mesh's hit but near to the true surface. The column "
    "<i>rules</i> says what rules the error against the true surface: where GRID's own is "
    "half of its mean square along the ray and more, a finer level helps more than a better representation. In the charts, "
    "marks at the bottom are errors below a thousandth of a pixel.</p>"
)


def true_errors(row, view):
    """Errors against the true surface, or None."""
    return row.views.get(view, {}).get("errors_to_true_surface")


def of_grid(data, row, view):
    grid = data.pick(row.scene, row.level, "GRID", view, job=row.job)
    return true_errors(grid, view) if grid else None


def ruling(total, tessellation):
    """Which error is larger. Both in pixels: a representation's and GRID's against the true surface. Independent errors
    add up as squares."""
    return "compression" if total**2 - tessellation**2 > tessellation**2 else "tessellation"


def pixels(value):
    return f"{value:.4f}" if value < 1 else f.error_text(value)


def names(row, view):
    return [f"{escape(row.scene)} {p.label(row.label)}", str(row.level), escape(view)]


def mesh_cells(row, view):
    mesh = row.errors(view)
    return names(row, view) + [
        pixels(mesh["median_pixels"]),
        pixels(mesh["p99_pixels"]),
        f.signed(mesh["bias_pixels"]),
        f"{mesh['normal_median_degrees']:.2f}",
        str(mesh.get("flipped_normals", "-")),
        pixels(mesh["uv_median_cells"]),
    ]


def true_cells(data, row, view):
    true, grid = true_errors(row, view), of_grid(data, row, view)
    out = names(row, view) + [pixels(true[key]) for key in ("median_pixels", "p99_pixels")]
    out += [f.signed(true["bias_pixels"]), f"{true['normal_median_degrees']:.2f}", pixels(true["uv_median_cells"])]
    known = grid and row.kind != "GRID"
    return out + [ruling(true["rmse_along_ray_pixels"], grid["rmse_along_ray_pixels"]) if known else "-"]


def tables(data, rows):
    """Against the mesh, and against the true surface."""
    shown = [(row, view) for row in rows for view in row.views if true_errors(row, view)]
    mesh = [mesh_cells(row, view) for row, view in shown if row.kind != "GRID"]
    return (
        ("<h4>Against the mesh</h4>" + p.table(MESH_HEADS, mesh) if mesh else "")
        + "<h4>Against the true surface</h4>"
        + p.table(TRUE_HEADS, [true_cells(data, row, view) for row, view in shown])
    )


def error_pairs(title, pairs):
    """The p99 of errors in pixels as marks, and their medians as hollow ones. pairs: (label, errors against the mesh or None,
    errors against the true surface)."""

    def draw(axes, theme):
        found = [errors[key] for pair in pairs for errors in pair[1:] if errors for key in ("median_pixels", "p99_pixels")]
        shown = [value for value in found if value >= f.EXACT]
        low, high = min(shown, default=f.EXACT) / 2, max(shown, default=2 * f.EXACT) * 1.5
        series = (("against the mesh", 1, -0.15, "#0072B2", "o"), ("against the true surface", 2, 0.15, "#E69F00", "D"))
        for name, column, shift, colour, mark in series:
            here = [(i + shift, pair[column]) for i, pair in enumerate(pairs) if pair[column]]
            xs = [x for x, _ in here]
            p99, median = ([max(low, e[key]) for _, e in here] for key in ("p99_pixels", "median_pixels"))
            axes.vlines(xs, low, p99, color=theme["grid"], linewidth=2)
            axes.plot(xs, p99, mark, color=colour, markersize=5.5, label=name, clip_on=False, zorder=3)
            axes.plot(xs, median, mark, color=colour, markersize=5, markerfacecolor="none", clip_on=False, zorder=3)
        axes.set_yscale("log")
        axes.set_ylim(low, high)
        f.log_axis(axes.yaxis)
        f.names_below(axes, [pair[0] for pair in pairs])
        axes.set_ylabel("p99 (hollow: median), pixels")
        axes.set_title(title)
        f.legend(axes, 2)

    return f.themed(draw)


def charts(data, rows):
    """A chart a scene, of its finest level up to 6, full view."""
    parts = []
    for scene in sorted({row.scene for row in rows}):
        level = finest(data, scene)
        here = [row for row in rows if row.scene == scene and row.level == level and true_errors(row, "full")]
        here.sort(key=lambda row: f.sort_key(row.label))
        if len(here) < 2:
            continue
        pairs = [
            (
                row.label,
                None if row.kind == "GRID" else row.errors("full"),
                true_errors(row, "full"),
            )
            for row in here
        ]
        parts.append(
            p.chart(error_pairs(f"{scene}, level {level}", pairs), f"Errors against mesh and true surface, {scene}")
        )
    return p.charts(parts) if parts else ""


def finest(data, scene):
    levels = data.levels(scene)
    return max([level for level in levels if level <= 6] or levels)


def errors(data):
    rows = [row for scene in data.scenes() for row in data.of_scene(scene)]
    rows = [row for row in rows if any(true_errors(row, view) for view in row.views)]
    rows.sort(key=lambda row: (row.scene, row.level, f.sort_key(row.label)))
    if not rows:
        body = p.missing("errors against the true surface: cbvh_bench --true-surface N")
    else:
        scenes = {row.scene for row in rows}
        scene = data.main_scene() if data.main_scene() in scenes else min(scenes)
        fine = [row for row in rows if (row.scene, row.level) == (scene, finest(data, scene))]
        rest = [row for row in rows if row not in fine]
        body = charts(data, rows) + tables(data, fine)
        body += p.folded("The other scenes and levels", tables(data, rest)) if rest else ""
    return p.section(
        "errors", "Error of compression, and with tessellation", TEXT, body, commands=[row.command for row in rows]
    )
