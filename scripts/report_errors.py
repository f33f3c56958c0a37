# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on errors: compression alone, and with tessellation, side by side."""

from html import escape

import report_figures as f
import report_page as p

HEADS = (
    "",
    "level",
    "view",
    "<b>mesh</b>: RMSE",
    "median",
    "bias",
    "normal",
    "flipped",
    "(u,v)",
    "<b>true</b>: RMSE",
    "bias",
    "distance: RMSE",
    "median",
    "p99",
    "normal",
    "(u,v)",
    "rules",
)

TEXT = (
    "<p>Two errors of each hit. Against the <b>mesh</b>, GRID's of the same level: what compression costs. Against the "
    "<b>true</b> surface, OpenSubdiv's limit surface displaced by the heights as they are in the map, on a random sample "
    "of the hits: what tessellation and compression cost together, GRID's own error included. RMSE and bias are along "
    "the ray, in pixels, of hits within 5 pixels, a positive bias is behind; distance is to the nearest point of the "
    "true surface; normal and (u,v) are medians in degrees and in quads of the level; flipped counts normals that are more than 90 "
    "degrees from the mesh's. A ray that passes a silhouette in "
    "one of both hits another sheet, far from the mesh's hit but near to the true surface: such rays are in the RMSE "
    "against the mesh alone. The last column says what rules the error against the true surface: where GRID's own is "
    "half of its square and more, a finer level helps more than a better representation.</p>"
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


def cells(data, row, view):
    mesh, true, grid = row.errors(view), true_errors(row, view), of_grid(data, row, view)
    out = [f"{escape(row.scene)} {p.label(row.label)}", str(row.level), escape(view)]
    if row.kind == "GRID":
        out += ["-"] * 6
    else:
        out += [pixels(mesh["rmse_of_others_pixels"]), pixels(mesh["median_pixels"]), f"{mesh['bias_pixels']:+.4f}"]
        out += [f"{mesh['normal_median_degrees']:.2f}", str(mesh.get("flipped_normals", "-")), pixels(mesh["uv_median_cells"])]
    out += [pixels(true["rmse_along_ray_pixels"]), f"{true['bias_pixels']:+.4f}"]
    out += [pixels(true[key]) for key in ("rmse_pixels", "median_pixels", "p99_pixels")]
    out += [f"{true['normal_median_degrees']:.2f}", pixels(true["uv_median_cells"])]
    rules = ruling(true["rmse_along_ray_pixels"], grid["rmse_along_ray_pixels"]) if grid else "-"
    return out + ["-" if row.kind == "GRID" else rules]


def error_pairs(title, bars):
    """Bars of errors in pixels. bars: (label, against the mesh or None, against the true surface)."""

    def draw(axes, _):
        series = (("against the mesh", 1, -0.2, "#0072B2"), ("against the true surface", 2, 0.2, "#E69F00"))
        for name, column, shift, colour in series:
            here = [(i + shift, max(bar[column], f.EXACT)) for i, bar in enumerate(bars) if bar[column] is not None]
            axes.bar([x for x, _ in here], [y for _, y in here], 0.38, color=colour, label=name)
        axes.set_yscale("log")
        f.log_axis(axes.yaxis)
        axes.set_xticks(
            range(len(bars)), [f.math_label(bar[0]) for bar in bars], rotation=40, ha="right", rotation_mode="anchor"
        )
        axes.grid(axis="x", visible=False)
        axes.set_ylabel("RMSE along the ray, pixels")
        axes.set_title(title)
        axes.legend(ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.26), columnspacing=1.0, handlelength=1.2)

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
        bars = [
            (
                row.label,
                None if row.kind == "GRID" else row.errors("full")["rmse_of_others_pixels"],
                true_errors(row, "full")["rmse_along_ray_pixels"],
            )
            for row in here
        ]
        parts.append(
            p.chart(error_pairs(f"{scene}, level {level}", bars), f"Errors against mesh and true surface, {scene}")
        )
    return f'<div class="charts">{"".join(parts)}</div>' if parts else ""


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

        def table(chosen):
            return p.table(
                HEADS, [cells(data, row, view) for row in chosen for view in row.views if true_errors(row, view)]
            )

        fine = [row for row in rows if row.level == finest(data, row.scene)]
        rest = [row for row in rows if row not in fine]
        body = charts(data, rows) + table(fine)
        if rest:
            body += f"<details><summary>The other levels</summary>{table(rest)}</details>"
    return p.section(
        "errors", "Error of compression, and with tessellation", TEXT, body, p.command(*(row.command for row in rows))
    )
