# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""A plot for each scene: speeds and memory of all representations over their errors."""

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402

from .formats import EXACT  # noqa: E402

AXES = {"coherent rays": "coherent_of_grid", "incoherent rays": "incoherent_of_grid", "memory": "memory_bytes_per_quad"}
UNITS = {"memory": "bytes per quad"}
FINER = "errors_to_reference_level_p99_pixels"


def points(rows):
    """Returns rows of one scene whose errors can be compared, with a column `error`: all of them if every one was
    measured against a finer level, otherwise those of the level with the most representations."""
    rows = rows[~rows.kind.isin(("NAIVE", "NAIVE-compact"))]
    if len(rows) and rows[FINER].notna().all():
        return rows.assign(error=rows[FINER])
    counts = rows.level.value_counts()
    rows = rows[rows.level == counts[counts == counts.max()].index.max()] if len(rows) else rows
    return rows.assign(error=rows.errors_p99_pixels)


def write(path, rows, scene):
    """Writes the plot as SVG. Returns False if there is nothing to compare."""
    rows = points(rows)
    if len(rows) < 2:
        return False
    with plt.rc_context({"svg.hashsalt": "cbvh", "axes.grid": True, "font.size": 8}):
        figure, all_axes = plt.subplots(1, len(AXES), figsize=(14, 4.5), layout="constrained")
        for axes, (title, column) in zip(all_axes, AXES.items()):
            for row in rows[rows[column].notna()].itertuples():
                place = max(row.error, EXACT), getattr(row, column)
                axes.plot(*place, "o")
                axes.annotate(f"{row.representation}, {row.level}", place, xytext=(3, 3), textcoords="offset points")
            axes.set(title=f"{scene}: {title}", xscale="log", xlabel="error, pixels, p99 (left edge: none)")
            axes.set_ylabel(UNITS.get(title, "times GRID's speed"))
        figure.savefig(path, metadata={"Date": None})
        plt.close(figure)
    return True
