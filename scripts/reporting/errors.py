# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Errors of compression, errors of compression and tessellation, and the errors that heights of 4 bits could reach."""

from . import figures as f
from .formats import EXACT, Fold, is_known, pixels, signed, table

MESH, TRUE = "errors", "errors_to_true_surface"  # against GRID's mesh of the same level, against the true surface
SERIES = {MESH: ("against the mesh", f.BLUE, "o"), TRUE: ("against the true surface", f.ORANGE, "D")}
TARGET = 1.5  # largest accepted ratio to the error of 4 bits
AWAY = "away_from_silhouettes_inlier_rmse_pixels"
COMPARED = {  # columns of cLEAF-only and of 4 bits
    "median": ("errors_median_pixels", "bins_of_4_bits_median_pixels"),
    "RMSE away": (f"errors_{AWAY}", f"bins_of_4_bits_{AWAY}"),
    "RMSE": ("errors_inlier_rmse_pixels", "bins_of_4_bits_inlier_rmse_pixels"),
}


def known_errors(row, kind):
    """True if a row has meaningful errors of a kind; GRID has none against itself."""
    return is_known(row[f"{kind}_p99_pixels"]) and (kind, row.kind) != (MESH, "GRID")


def dominant(row):
    """The larger of the errors along the ray. Independent errors add up as squares."""
    total, tessellation = row[f"{TRUE}_rmse_along_ray_pixels"], row.along_of_grid
    if row.kind == "GRID" or not is_known(tessellation):
        return None
    return "compression" if total**2 > 2 * tessellation**2 else "tessellation"


def error_ratio(row, name):
    """Error of cLEAF-only divided by the error of 4 bits, or None if the latter is 0."""
    ours, bins = COMPARED[name]
    return row[ours] / row[bins] if row[bins] else None


def verdict(row):
    ratios = [error_ratio(row, name) for name in ("median", "RMSE away")]
    return "not measured" if None in ratios else "holds" if max(ratios) <= TARGET else "does not hold"


def column(head, kind, key, form):
    return head, lambda row: row[f"{kind}_{key}"] if known_errors(row, kind) else None, form


WHERE = [("", lambda row: f"{row.scene} {row.representation}", str), ("level", "level", str), ("view", "view", str)]
BOTH = list(WHERE)
for prefix, of in (("mesh: ", MESH), ("true: ", TRUE)):
    BOTH += [column(f"{prefix}{head}", of, f"{head}_pixels", pixels) for head in ("median", "p99")]
    BOTH += [column(f"{prefix}bias", of, "bias_pixels", signed)]
    BOTH += [column(f"{prefix}normal", of, "normal_median_degrees", "{:.2f}")]
    BOTH += [column(f"{prefix}(u,v)", of, "uv_median_quads", pixels)]
BOTH += [column("mesh: flipped", MESH, "flipped_normals", "{:.0f}"), ("rules", dominant, str)]
BINS = [*WHERE, ("bins: median", lambda row: row.bins_of_4_bits_quantiles_pixels[9], pixels)]
BINS += [("bins: 90%", lambda row: row.bins_of_4_bits_quantiles_pixels[17], pixels)]
BINS += [(f"4 bits: {name}", bins, pixels) for name, (_, bins) in COMPARED.items()]
BINS += [(f"cLEAF-only: {name}", ours, pixels) for name, (ours, _) in COMPARED.items()]
BINS += [(f"ratio: {name}", lambda row, name=name: error_ratio(row, name), "{:.2f}") for name in COMPARED]
BINS += [(f"up to {TARGET}", verdict, str)]


def draw(axes, rows, title, kinds):
    """Draws the p99 of errors as marks with their values, and medians as hollow marks. rows: from top to bottom."""
    shifts = dict(zip(kinds, (-0.2, 0.2) if len(kinds) > 1 else (0,)))
    marks = [
        (i + shifts[kind], row[f"{kind}_median_pixels"], row[f"{kind}_p99_pixels"], *SERIES[kind][1:])
        for i, row in enumerate(rows) for kind in kinds if known_errors(row, kind)
    ]  # fmt: skip
    errors = [error for _, median, p99, *_ in marks for error in (median, p99) if error >= EXACT]
    low, high = min(errors, default=EXACT) / 3, max(errors, default=EXACT)
    for name, color, mark in (SERIES[kind] for kind in kinds if len(kinds) > 1):
        axes.plot([], [], mark, color=color, label=name)
    for y, median, p99, color, mark in marks:
        axes.plot([low, max(p99, low)], [y, y], color=f.LINES, linewidth=2)
        for value, fill in ((median, "none"), (p99, color)):
            axes.plot([value] * (value >= EXACT), [y] * (value >= EXACT), mark, color=color, mfc=fill, markersize=5.5)
        axes.text(1.3 * max(p99, low), y, f"{p99:.2g}" if p99 >= EXACT else "none", va="center", fontsize=8)
    f.row_labels(axes, [row.representation for row in rows])
    f.log_axis(axes, "x", low, 6 * high)
    f.set_labels(axes, title, "pixels, p99 (hollow: median)", columns=2)


def section(data):
    rows, keys, along = data.views(), ["scene", "level", "view", "job"], f"{TRUE}_rmse_along_ray_pixels"
    rows = rows[rows[f"{TRUE}_median_pixels"].notna()]
    grid = rows[rows.kind == "GRID"].rename(columns={along: "along_of_grid"}).drop_duplicates(keys)
    rows = rows.merge(grid[[*keys, "along_of_grid"]], "left", keys)
    charts, finest = [], rows.level == rows.scene.map(data.finest)
    for scene, found in rows[(rows["view"] == "full") & finest].groupby("scene"):
        found, title = [row for _, row in found.iterrows()], f"{scene}, level {found.level.iloc[0]}"
        name = f"Errors against mesh and true surface, {scene}"
        charts += [f.chart(name, 1.4 + 0.36 * len(found), draw, found, title, SERIES)] if len(found) > 1 else []
    main = finest & (rows.scene == next((scene for scene in data.scenes() if (rows.scene == scene).any()), None))
    others = Fold("The other scenes and levels", [table(rows[~main], BOTH)])
    return [charts, table(rows[main], BOTH), others] if len(rows) else [], rows.command


def draw_bins(axes, rows):
    """Draws the distribution of bin sizes, a line for each row."""
    for row in rows.itertuples():
        name = f"{row.scene}, level {row.level}"
        axes.plot(row.bins_of_4_bits_quantiles_pixels, range(5, 100, 5), label=name, linewidth=1.4)
    f.log_axis(axes, "x")
    axes.set_ylim(0, 100)
    f.set_labels(axes, "Bins of 4 bits", "size of a bin along the ray, pixels", "% of hits with smaller bins", 2)


def bins(data):
    rows = data.views()
    rows = rows[(rows.bins_of_4_bits_hits > 0) & (rows.level == rows.scene.map(data.finest))]
    full = rows[rows["view"] == "full"].drop_duplicates("scene")
    charts = [f.chart("Sizes of bins of 4 bits", 3.9, draw_bins, full)] if len(full) else []
    return [charts, table(rows, BINS)] if len(rows) else [], rows.command
