# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The first screen: memory, speed and error of compression."""

from . import errors, memory
from . import figures as f
from .data import RAY_SETS
from .formats import is_known, mib, percent, pixels, ratio, table, value_range
from .levels import fallback_share

HEADLINE_ORDER = ("cVERT", "cLEAF^2", "cLEAF-only^2", "cLEAF-only^3", "cVOXEL^3", "cVOXEL^2", "cGRID^2")
CHARTED = ("GRID", "cGRID^2", "cVOXEL^2", "cVOXEL^3", "cLEAF^2", "cLEAF-only^2", "cLEAF-only^3", "cVERT")
PLACES = [("scene", "scene", str), ("level", "level", str), ("view", "view", str), ("times smaller", "smaller", ratio)]
PLACES += [(f"{rays} rays, times GRID's", f"{rays}_of_grid", ratio) for rays in RAY_SETS]
PLACES += [("p99, pixels", "errors_p99_pixels", pixels)]


def places(data):
    """Rows of one representation in all scenes, levels and views, with GRID's values in columns that end in _grid. The
    first row is the main scene at the finest level up to 6, in the full view. Empty if nothing was compressed."""
    views, keys = data.views(), ["scene", "level", "view"]
    # copied into one piece of memory
    views = views.merge(views[views.kind == "GRID"], "inner", keys, suffixes=("", "_grid")).copy()
    views["smaller"] = views.memory_live_bytes_grid / views.memory_live_bytes
    order = {"other": views.scene != data.main_scene(), "fine": views.level > 6, "coarse": -views.level}
    ranks = dict(zip(HEADLINE_ORDER, range(len(HEADLINE_ORDER))))
    order |= {"part": views["view"] != "full", "rank": views.representation.map(ranks)}
    views = views.assign(**order)[order["rank"].notna()].sort_values(list(order), kind="stable")
    return views[views.representation == next(iter(views.representation), None)]


def statements(row, found):
    """For memory, speed and error: the figure, a sentence, and the range over all places."""
    size, size_of_grid = mib(row.memory_live_bytes), mib(row.memory_live_bytes_grid)
    memory_text = (
        f"{row.representation} stores {row.scene} at level {row.level}, {row.quads / 1e6:.3g} million quads, in {size} "
        f"({row.memory_bytes_per_quad:.2f} bytes per quad). Embree's GRID needs {size_of_grid} "
        f"({row.memory_bytes_per_quad_grid:.2f})."
    )
    rays = [rays for rays in RAY_SETS if is_known(row[f"{rays}_of_grid"])]
    traced = [f"{row[name]:.3g} million {name} rays (GRID: {row[f'{name}_grid']:.3g})" for name in rays]
    traced = f"One thread traces {' and '.join(traced) or 'an unknown number of rays'}"
    error_text = (
        f"99% of the hits are closer to GRID's (p99). The median is {pixels(row.errors_median_pixels)} pixels; "
        f"{row.errors_beyond_5_pixels:.0f} of {row.errors_rays:,.0f} rays hit more than 5 pixels away."
    )
    true = [row[f"{errors.TRUE}_p99_pixels{end}"] for end in ("", "_grid")]
    if all(map(is_known, true)):
        error_text += f" To the true surface p99 is {pixels(true[0])}, and {pixels(true[1])} for GRID."
    times, speeds = "times GRID's speed", " and ".join(ratio(row[f"{name}_of_grid"]) for name in rays)
    errors_of_all = value_range(found.errors_p99_pixels, pixels)
    of_all = value_range([*found.coherent_of_grid, *found.incoherent_of_grid], ratio)
    return [
        (f"{ratio(row.smaller)} times smaller", memory_text, f"{value_range(found.smaller, ratio)} times smaller"),
        (f"{speeds} {times}" if rays else "no speed", f"{traced} per second.", f"{of_all} {times}"),
        (f"{pixels(row.errors_p99_pixels)} pixels of error", error_text, f"{errors_of_all} pixels"),
    ]


def draw_speed(axes, rows):
    for rays, shift, color in (("coherent", -0.19, f.BLUE), ("incoherent", 0.19, f.ORANGE)):
        found = [(i + shift, row[f"{rays}_of_grid"]) for i, row in enumerate(rows) if is_known(row[f"{rays}_of_grid"])]
        axes.barh([y for y, _ in found], [value for _, value in found], 0.36, color=color, label=rays)
        for y, value in found:
            axes.text(value, y, f" {value:.2f}", va="center", fontsize=8)
    f.row_labels(axes, [row.representation for row in rows])
    axes.set_xlim(0, 1.25 * max(axes.get_xlim()[1], 1.0))
    axes.axvline(1.0, color=f.INK, linewidth=0.8, linestyle=":")
    f.set_labels(axes, "Speed", "multiples of GRID's", columns=2)


def first_screen(data):
    """Data for the templates: the row of the headline, statements about it, and charts of all representations."""
    found = places(data)
    if found.empty:
        return {"on_gpu": (data.table.origin == "gpu").any()}
    row = found.iloc[0]
    rows = [row for row in (data.pick(row.scene, row.level, label) for label in CHARTED) if row is not None]
    height, texts = 1.6 + 0.28 * len(rows), [f"{row.memory_bytes_per_quad:.2f}" for row in rows]
    per_quad = (memory.stack, rows, "Memory", "bytes per quad", lambda row: 1 / row.quads, texts)
    charts = [f.chart("Bytes per quad", height, *per_quad), f.chart("Speed relative to GRID", height, draw_speed, rows)]
    charts.append(f.chart("Error", height, errors.draw, rows, "Error", [errors.MESH]))
    shares = [(row.representation, fallback_share(row)) for row in rows if fallback_share(row)]
    fallbacks = [f"{label} stores {percent(share)} of its quads as cVERT." for label, share in shares]
    caption = (
        f"{row.scene}, level {row.level}, {row['view']} view, single rays, one thread of {row.run_cpu} ({data.isa}). "
        f"Errors are distances to GRID's hits: p99, hollow the median. {' '.join(fallbacks)}"
    )
    everywhere = table(found.sort_values(["scene", "level", "view"]), PLACES, 3)
    found = {"statements": statements(row, found), "charts": charts, "caption": caption, "places": everywhere}
    return {"row": row, **found}
