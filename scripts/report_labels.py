# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Labels of the marks in a chart, placed so that they cover neither marks nor each other."""

LABEL_SIZE = 8.5  # points
DIGIT = (0.62 * LABEL_SIZE, 0.95 * LABEL_SIZE)  # width and height of one, a little more than the font's
RAISED = 1.3  # times as high is a label with a raised part
SIDES = ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, 1), (1, -1), (-1, -1))
DIRECTIONS = [(right, up, away) for away in (1, 6, 12) for right, up in SIDES]  # the nearest are tried first


def mark_size(level):
    """In points: the larger a mark, the higher its level."""
    return 3.2 + 1.0 * max(0, level - 3)


def overlap(a, b):
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def box(x, y, width, height):
    """Around a centre: left, bottom, right, top."""
    return (x - width / 2, y - height / 2, x + width / 2, y + height / 2)


def shown(text):
    """A label without the signs that raise a part of it."""
    return text.replace("$^{", "").replace("}$", "")


def corners(line):
    """The boxes of a line's pieces, which run along the axes."""
    pairs = zip(line, line[1:])
    return [(min(a[0], b[0]), min(a[1], b[1]), max(a[0], b[0]), max(a[1], b[1])) for a, b in pairs]


def place_labels(points, bounds, others=()):
    """Where labels go so that none covers a mark, another label, one of the others or the edge; those that find no place
    are left out. points: (x, y, size of the mark, text), and no label where the text is empty; bounds: as box, and so
    are the others; all in points of the page. Returns {index: (x, y) of a centre}."""
    taken = [box(x, y, size, size) for x, y, size, _ in points] + list(others)
    places = {}
    for i, (x, y, size, text) in enumerate(points):
        width, height = DIGIT[0] * len(shown(text)), DIGIT[1] * (1 if shown(text) == text else RAISED)
        for right, up, away in DIRECTIONS if text else ():
            centre = (x + right * (size + width + away) / 2, y + up * (size + height + away) / 2)
            here = box(*centre, width, height)
            inside = bounds[0] <= here[0] and bounds[1] <= here[1] and here[2] <= bounds[2] and here[3] <= bounds[3]
            if inside and not any(overlap(here, other) for other in taken):
                taken.append(here)
                places[i] = centre
                break
    return places


def write_labels(axes, marks, ink, line=()):
    """marks: (x, y, level, text) in the units of the axes, which have all else that they will have. line: corners of one
    that labels must not cover, whose pieces run along the axes."""
    axes.figure.draw_without_rendering()  # so that the axes have their place, which they keep
    axes.figure.set_layout_engine("none")
    points_of_pixel = 72.0 / axes.figure.dpi
    at = axes.transData.transform([mark[:2] for mark in marks]) * points_of_pixel
    bounds = tuple(v * points_of_pixel for v in axes.get_window_extent().extents)
    points = [(x, y, mark_size(level), text) for (x, y), (_, _, level, text) in zip(at, marks)]
    others = corners(axes.transData.transform(line) * points_of_pixel) if len(line) else ()
    for i, (x, y) in place_labels(points, bounds, others).items():
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
