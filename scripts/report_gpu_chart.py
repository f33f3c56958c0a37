# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The chart of the section on GPUs: speed against memory, a line a representation, a mark a level."""

from matplotlib.ticker import LogLocator

import report_figures as f

LABEL_SIZE = 8.5  # points
DIGIT = (0.62 * LABEL_SIZE, 0.95 * LABEL_SIZE)  # width and height of one, a little more than the font's


def mark_size(level):
    """In points, as in the charts of error."""
    return 3.2 + 1.0 * max(0, level - 3)


def overlap(a, b):
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def box(x, y, width, height):
    """Around a centre: left, bottom, right, top."""
    return (x - width / 2, y - height / 2, x + width / 2, y + height / 2)


def place_labels(points, bounds):
    """Where labels go so that none covers a mark, another label or the edge; those that find no place are left out.
    points: (x, y, size of the mark, text); bounds: as box; all in points of the page. Returns {index: (x, y) of a
    centre}."""
    taken = [box(x, y, size, size) for x, y, size, _ in points]
    places = {}
    for i, (x, y, size, text) in enumerate(points):
        width, height = DIGIT[0] * len(text), DIGIT[1]
        for right, up in ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, 1), (1, -1), (-1, -1)):
            centre = (x + right * (size + width + 1) / 2, y + up * (size + height + 1) / 2)
            here = box(*centre, width, height)
            inside = bounds[0] <= here[0] and bounds[1] <= here[1] and here[2] <= bounds[2] and here[3] <= bounds[3]
            if inside and not any(overlap(here, other) for other in taken):
                taken.append(here)
                places[i] = centre
                break
    return places


def write_levels(axes, marks, ink):
    """marks: (bytes a quad, speed, level)."""
    axes.figure.draw_without_rendering()  # so that the axes have their place
    points_of_pixel = 72.0 / axes.figure.dpi
    at = axes.transData.transform([(x, y) for x, y, _ in marks]) * points_of_pixel
    bounds = tuple(v * points_of_pixel for v in axes.get_window_extent().extents)
    points = [(x, y, mark_size(level), str(level)) for (x, y), (_, _, level) in zip(at, marks)]
    for i, (x, y) in place_labels(points, bounds).items():
        text = axes.annotate(
            points[i][3],
            marks[i][:2],
            xytext=(x - at[i][0], y - at[i][1]),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=LABEL_SIZE,
            color=ink,
        )
        text.set_in_layout(False)


def speed_against_memory(title, lines):
    """lines: {label: [(bytes a quad on the device, millions of rays a second, level)]}."""
    labels = sorted(lines, key=f.sort_key)

    def draw(axes, theme):
        seen = set()
        for label in labels:
            kind = label.partition("^")[0]
            colour, points = f.KIND_COLOURS.get(kind, "#777777"), sorted(lines[label], key=lambda point: point[2])
            hollow = {"markerfacecolor": "none"} if kind in seen else {}
            axes.plot([p[0] for p in points], [p[1] for p in points], "-", color=colour, linewidth=1, alpha=0.5)
            for x, y, level in points:
                axes.plot(x, y, f.KIND_MARKS.get(kind, "o"), color=colour, markersize=mark_size(level), **hollow)
            axes.plot([], [], f.KIND_MARKS.get(kind, "o"), color=colour, markersize=6, label=f.math_label(label), **hollow)
            seen.add(kind)
        marks = [mark for label in labels for mark in lines[label]]
        axes.set_xscale("log")
        axes.set_xlim(min(m[0] for m in marks) / 1.5, max(m[0] for m in marks) * 1.5)
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=20))
        f.log_axis(axes.xaxis)
        axes.set_ylim(0, 1.12 * max(m[1] for m in marks))
        axes.set_xlabel("bytes a quad, on the device and imported")
        axes.set_ylabel("million rays a second")
        axes.set_title(title)
        axes.legend(ncols=4, loc="upper center", bbox_to_anchor=(0.46, -0.2), columnspacing=0.9, handletextpad=0.2)
        write_levels(axes, marks, theme["ink"])

    return f.themed(draw, height=3.9)
