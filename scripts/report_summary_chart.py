# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The picture of the first screen: memory, speed and error of each representation, in bars side by side."""

import report_figures as f
import report_memory as memory

COHERENT, INCOHERENT = "#0072B2", "#E69F00"


def draw_memory(axes, rows, theme):
    memory.stack(
        axes,
        rows,
        lambda row, count: count / row.quads,
        lambda row: f"{row.memory['bytes_per_quad']:.2f}",
        theme,
    )
    axes.set_title("Memory, bytes a quad")


def draw_speed(axes, rows, theme):
    for ray_set, shift, colour in (("coherent", -0.19, COHERENT), ("incoherent", 0.19, INCOHERENT)):
        for i, row in enumerate(rows):
            speed = row.speed("full", ray_set)
            if speed:
                ratio = speed["relative_to_grid"]["median"]
                axes.barh(i + shift, ratio, 0.36, color=colour)
                axes.text(ratio, i + shift, f" {ratio:.2f}", va="center", fontsize=8, color=theme["ink"])
    f.names_beside(axes, [row.label for row in rows])
    axes.set_xlim(0, 1.25 * max(axes.get_xlim()[1], 1.0))
    axes.axvline(1.0, color=theme["ink"], linewidth=0.8, linestyle=":")
    axes.set_title("Speed, times GRID's")
    handles = [axes.barh(-9, 0, color=colour) for colour in (COHERENT, INCOHERENT)]
    axes.legend(handles, ["coherent", "incoherent"], ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.12))


def draw_error(axes, rows, theme):
    """What 99 of 100 hits stay below, and what half of them do where that is to be seen."""
    errors = {i: row.errors("full")["p99_pixels"] for i, row in enumerate(rows) if row.errors("full")}
    medians = {i: rows[i].errors("full")["median_pixels"] for i in errors}
    seen = [error for error in [*errors.values(), *medians.values()] if error >= f.EXACT]
    f.names_beside(axes, [row.label for row in rows])
    axes.set_title("Error, pixels, p99 (hollow: median)")
    low, high = min(seen, default=f.EXACT) / 3, max(seen, default=f.EXACT)
    axes.set_xscale("log")
    axes.set_xlim(low, 6 * high)
    f.log_axis(axes.xaxis)
    for i, error in errors.items():
        exact = error < f.EXACT
        end = low if exact else error
        axes.plot([low, end], [i, i], color=theme["grid"], linewidth=2)
        axes.plot([] if exact else end, [] if exact else i, "o", color="#D55E00", markersize=7)
        if medians[i] >= f.EXACT:
            axes.plot(medians[i], i, "o", color="#D55E00", markerfacecolor="none", markersize=6)
        text = "none" if exact else f"{error:.2g}"
        axes.text(1.25 * end, i, text, va="center", fontsize=8.5, color=theme["ink"])


def charts(rows):
    """For desks and for phones, as report_figures.themed gives them."""

    def draw(all_axes, theme):
        for axes, draw_one in zip(all_axes.flat, (draw_memory, draw_speed, draw_error)):
            draw_one(axes, rows, theme)
        handles = [all_axes.flat[0].barh(-9, 0, color=colour) for colour in memory.COLOURS.values()]
        all_axes.flat[0].legend(handles, memory.COLOURS, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.12))

    height = 1.1 + 0.28 * len(rows)
    return f.themed(draw, 12.5, height + 0.2, columns=3), f.themed(draw, 4.4, 3 * height + 0.6, rows=3)
