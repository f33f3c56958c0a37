# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on what heights of 4 bits could give, and what cLEAF-only does, which has nothing else."""

from html import escape

import report_figures as f
import report_page as p
from report_errors import finest, pixels
from report_tables import verdict

TARGET = 1.5  # times the yardstick, at most

# of a view: errors of cLEAF-only and bins, of which rays, and which of their figures
COMPARED = (
    ("errors", "bins_of_4_bits", "median_pixels"),
    ("errors_away_from_silhouettes", "bins_of_4_bits_away_from_silhouettes", "rmse_of_others_pixels"),
    ("errors", "bins_of_4_bits", "rmse_of_others_pixels"),
)

BINS_HEADS = ("", "view", "bins: median", "bins: 90%", "4 bits: median", "4 bits: RMSE away", "4 bits: RMSE")
OURS_HEADS = (
    "",
    "view",
    "median",
    "RMSE away",
    "RMSE",
    "ratio: median",
    "ratio: RMSE away",
    f"up to {TARGET}",
    "ratio: RMSE",
)

TEXT = (
    "<p>A yardstick out of the surface alone: the paper's four heights of 4 bits, in the tightest box of each quad along "
    "z, the normal of the block's corners before displacement. A bin is a sixteenth of that box; heights rounded to its "
    "middle leave an error of up to half a bin either way, all alike. Bins and errors are along the ray, in pixels, on a "
    "random sample of GRID's hits; medians are of all hits, RMSE is of errors within 5 pixels, on both sides.</p>"
    "<p>The yardstick leaves out that interpolation averages rounded heights, which would take its RMSE down to 0.71 of "
    "it, and three errors that the RMSE of cLEAF-only contains. Rays that pass a silhouette on one side only: “away” means "
    "away from silhouettes, on both sides, where all of 3 x 3 pixels see the plane of the hit in the middle, to 3 pixels. "
    "Errors across z. And GRID's two triangles leave the bilinear patch of a quad by a quarter of its twist, four bins "
    "where one corner stands out: against the true surface, in the section above, that counts for neither.</p>"
)


def bins(row, view):
    """Sizes of bins and the errors they leave, or None."""
    found = row.views.get(view, {}).get("bins_of_4_bits")
    return found if found and found["hits"] else None


def quantile(found, percent):
    return found["quantiles_pixels"][percent // 5 - 1]


def compared(row, view):
    """Figures of 4 bits, ours, and ours over theirs, None where 4 bits leave no error; each as COMPARED."""
    found = row.views[view]
    best = [found[bins][key] for _, bins, key in COMPARED]
    ours = [found[errors][key] for errors, _, key in COMPARED]
    return best, ours, [a / b if b else None for a, b in zip(ours, best)]


def names(row, view):
    return [f"{escape(row.scene)} {p.label(row.label)}", escape(view)]


def bins_cells(row, view):
    best, _, _ = compared(row, view)
    return names(row, view) + [pixels(x) for x in [quantile(bins(row, view), percent) for percent in (50, 90)] + best]


def ours_cells(row, view):
    _, ours, ratios = compared(row, view)
    median, away, rmse = ["-" if ratio is None else f"{ratio:.2f}" for ratio in ratios]
    holds = verdict(None if None in ratios[:2] else max(ratios[:2]) <= TARGET)
    return names(row, view) + [pixels(figure) for figure in ours] + [median, away, holds, rmse]


def tables(rows):
    shown = [(row, view) for row in rows for view in row.views if bins(row, view)]
    return (
        "<h4>Sizes of bins, and the yardstick</h4>"
        + p.table(BINS_HEADS, [bins_cells(row, view) for row, view in shown])
        + "<h4>cLEAF-only, and how many times the yardstick it is</h4>"
        + p.table(OURS_HEADS, [ours_cells(row, view) for row, view in shown])
    )


def distribution(rows):
    """How large bins are in the full view, a line a row."""

    def draw(axes, _):
        for row in rows:
            sizes = bins(row, "full")["quantiles_pixels"]
            axes.plot(sizes, range(5, 100, 5), label=f"{row.scene}, level {row.level}", linewidth=1.4)
        axes.set_xscale("log")
        f.log_axis(axes.xaxis)
        axes.set_ylim(0, 100)
        axes.set_xlabel("size of a bin along the ray, pixels")
        axes.set_ylabel("% of hits with smaller ones")
        axes.set_title("Bins of 4 bits")
        f.legend(axes, 2)

    return f.themed(draw, height=3.9)


def section(data):
    rows = [row for scene in data.scenes() for row in data.of_scene(scene) if row.level == finest(data, scene)]
    rows = [row for row in rows if any(bins(row, view) for view in row.views)]
    if not rows:
        body = p.missing("bins of 4 bits: cbvh_bench --representation cleaf-only^2 --true-surface N")
    else:
        coarsest = {}  # frame level of each scene, rows come in their order
        for row in rows:
            if bins(row, "full"):
                coarsest.setdefault(row.scene, row)
        chart = p.chart(distribution(coarsest.values()), "Sizes of bins of 4 bits") if coarsest else ""
        body = (p.charts([chart]) if chart else "") + tables(rows)
    return p.section("bins", "What 4 bits can give", TEXT, body, commands=[row.command for row in rows])
