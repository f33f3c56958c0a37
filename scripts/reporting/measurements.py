# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Tables of all measurements: memory and errors of each scene, and speeds of each function of the API."""

from .data import RAY_SETS, in_order
from .formats import Fold, percent, pixels, signed, table
from .levels import fallback_share

WHERE = [("level", "level", str), ("", "representation", str)]
BUILDS = [
    *WHERE, ("MiB", "mib", "{:.2f}"), ("bytes per quad", "memory_bytes_per_quad", "{:.2f}"),
    ("stored as cVERT", fallback_share, percent), ("of GRID", "part_of_grid", percent),
    ("peak, MiB", lambda row: row.memory_peak_bytes / 2**20, "{:.1f}"), ("build, s", "build_seconds", "{:.3f}"),
]  # fmt: skip
for rays in RAY_SETS:
    BUILDS += [(f"{rays}, Mrays/s", rays, "{:.3f}"), (f"{rays}, of GRID", f"{rays}_of_grid", "{:.2f}")]
ERRORS = [
    *WHERE, ("view", "view", str), ("median", "errors_median_pixels", pixels), ("p99", "errors_p99_pixels", pixels),
    ("max", "errors_max_pixels", pixels), ("rays beyond 5 pixels", "errors_beyond_5_pixels", "{:.0f}"),
    ("bias of the others", "errors_bias_pixels", signed), ("false hits", "errors_false_hits", "{:.0f}"),
    ("misses", "errors_misses", "{:.0f}"), ("bounces wrong", "bounced_wrong", percent),
    ("normal, degrees", "errors_normal_median_degrees", "{:.3f}"), ("the paper's RMSE", "errors_rmse_pixels", pixels),
    ("true surface: median", "errors_to_true_surface_median_pixels", pixels),
    ("true surface: p99", "errors_to_true_surface_p99_pixels", pixels),
]  # fmt: skip
PLACE = [("", lambda row: f"{row.scene} {row.representation}, level {row.level}", str), ("view", "view", str)]
PLACE += [("rays", "ray_set", str), ("query", "query", str), ("threads", "threads", "{:.0f}")]
SPEEDS = [*PLACE, ("instruction set", "isa", str), ("entrance", "mode", str)]
SPEEDS += [("Mrays/s", "mrays_per_second_median", "{:.3f}"), ("of GRID", "relative_to_grid_median", percent)]
SPEEDS += [("spread", "relative_to_grid_spread", percent), ("rounds", lambda row: len(row.seconds), str)]
MODES = ("single", "packet4", "packet8", "packet16", "stream")


def of_scene(data, scene):
    """Numbers of quads, and tables of memory and errors."""
    views, rows = data.views(scene=scene), data.full[data.full.scene == scene]
    grid = rows[rows.kind == "GRID"].set_index("level").mib
    rows = rows.assign(part_of_grid=rows.mib / rows.level.map(grid))
    wrong = (views.bounced_false_hits + views.bounced_misses) / views.bounced_rays.clip(lower=1)
    quads = ", ".join(f"{quads:,} at level {level}" for level, quads in dict(zip(views.level, views.quads)).items())
    memory = table(rows, BUILDS, 2, f"{scene}: memory, build and speed")
    return [f"Quads: {quads}.", memory, table(views.assign(bounced_wrong=wrong), ERRORS, 3, f"{scene}: error")]


def section(data):
    speeds = in_order(data.here[data.here.what == "speed"], "scene", "level", "representation", "isa", "job")
    parts = [Fold(scene, of_scene(data, scene), True) for scene in data.scenes()]
    parts.append(Fold("Every speed, and how far its ratios to GRID spread", [table(speeds, SPEEDS)]))
    return parts if len(data.here) else [], data.here.command


def entrances(data):
    """Speeds of each function of the API: millions per second, and percent of GRID's speed with the same function."""
    rows = data.of_isa[data.of_isa.what == "speed"]
    keys = ["scene", "level", "representation", "view", "ray_set", "query"]
    rows = rows[rows.job.isin(("entrances", "threads")) | rows.result.isin(rows[rows["mode"] != "single"].result)]
    text = rows.mrays_per_second_median.map("{:.2f}".format) + rows.relative_to_grid_median.map(" ({:.0%})".format)
    wide = rows.assign(text=text).pivot_table("text", [*keys, "threads"], "mode", aggfunc="first")
    wide = in_order(wide.reindex(columns=MODES).reset_index(), *keys, "threads")
    return [table(wide, [*PLACE, *((mode, mode, str) for mode in MODES)], 4)] if len(wide) else [], rows.command
