# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on speed and memory against error."""

from html import escape

import report_figures as f
import report_labels as labels
import report_page as p

TEXT = (
    "<p>Every representation, level and frame level is a point, larger for higher levels; those on the "
    "Pareto front are labelled with level and, raised, frame level. The error is what 99 of 100 hits stay below (p99): "
    "a few rays hit another sheet of the surface, behind a silhouette. Where one is the best in both there is no front, "
    "and a sentence says which. Where a scene was measured against a finer reference, the error "
    "is that of tessellation and compression together, and levels can be compared; otherwise it is that of compression "
    "alone, of one level, and GRID has none.</p>"
)


def points_of(data, scene, view, value):
    """(row, error, value) of a scene; and whether errors are against a finer mesh, as they are when all measurements of
    the scene, or of one job on it, have them."""

    def rows_of(job):
        return [row for row in data.of_scene(scene, job) if row.kind != "NAIVE" and view in row.views]

    rows, to_reference = rows_of(None), False
    for job in [None] + sorted({row.job for row in data.rows if row.scene == scene}):
        found = rows_of(job)
        if found and all(row.errors(view, True) for row in found):
            rows, to_reference = found, True
            break
    if rows and not to_reference:  # levels cannot be compared: the one that was measured most, the highest of those
        levels = [row.level for row in rows]
        most = max(levels, key=lambda level: (levels.count(level), level))
        rows = [row for row in rows if row.level == most]
    points = []
    for row in rows:
        errors, y = row.errors(view, to_reference), value(row, view)
        if errors and y:
            points.append((row, errors["p99_pixels"], y))
    return points, to_reference


def speed_value(ray_set):
    def value(row, view):
        speed = row.speed(view, ray_set)
        return speed["mrays_per_second"]["median"] if speed else None

    return value


def pareto(points, lower_is_better):
    """The points (error, value) that no other beats in both, by error."""
    front, best = [], None
    for error, value in sorted(points, key=lambda p: (p[0], p[1] if lower_is_better else -p[1])):
        if best is None or (value < best if lower_is_better else value > best):
            front.append((error, value))
            best = value
    return front


def steps(front, right):
    """Corners of the line through a front, each value kept up to the next error, the last up to the right."""
    line = [front[0]]
    for error, value in front[1:]:
        line += [(error, line[-1][1]), (error, value)]
    return line + [(right, line[-1][1])]


def left_edge(points):
    """Where errors are drawn that are smaller than EXACT. points: (row, error in pixels, value), as below."""
    return min([error for _, error, _ in points if error >= f.EXACT] or [2 * f.EXACT]) / 2.5


def place(points):
    """The points as they are drawn."""
    edge = left_edge(points)
    return [(row, error if error >= f.EXACT else edge, value) for row, error, value in points]


def front_of(placed, lower_is_better):
    return pareto([(error, value) for _, error, value in placed], lower_is_better)


def best_in_words(title, unit, points, lower_is_better):
    """HTML: the one that is best in both, where the front is that one alone and no plot would show more; else nothing."""
    placed = place(points)
    front = front_of(placed, lower_is_better)
    if len(front) != 1:
        return ""
    row, error, value = next(point for point, (_, *there) in zip(points, placed) if tuple(there) == front[0])
    pixels = f"{error:.2g} pixels" if error >= f.EXACT else f"less than {f.EXACT:g} pixels"
    return (
        f"<p><b>{escape(title)}:</b> {p.label(row.label)} at level {row.level} is the best of {len(points)} in both: "
        f"{value:.3g} {escape(unit)}; p99 {pixels}.</p>"
    )


def chart(title, unit, points, lower_is_better):
    """points: (row, error in pixels, value)."""

    def draw(axes, theme):
        edge, placed = left_edge(points), place(points)
        front = front_of(placed, lower_is_better)
        right = 1.6 * max(error for _, error, _ in placed)
        line = steps(front, right)
        axes.plot(*zip(*line), "-", color=theme["ink"], linewidth=1, alpha=0.6, label="Pareto front")
        seen, marks = set(), []
        for row, error, value in sorted(placed, key=lambda point: f.kind_order(point[0].kind)):
            axes.plot(
                error,
                value,
                f.KIND_MARKS.get(row.kind, "o"),
                color=f.KIND_COLOURS.get(row.kind, "#777777"),
                markersize=labels.mark_size(row.level),
                markeredgecolor=theme["ink"],
                markeredgewidth=0.3,
                label=None if row.kind in seen else row.kind,
            )
            seen.add(row.kind)
            text = f"{row.level}" if row.frame_level is None else f"{row.level}$^{{{row.frame_level}}}$"
            marks.append((error, value, row.level, text if (error, value) in front else ""))
        axes.set_xscale("log")
        axes.set_xlim(edge / 1.6, right)
        f.log_axis(axes.xaxis)
        if lower_is_better:
            axes.set_yscale("log")
            values = [value for _, _, value in placed]
            axes.set_ylim(min(values) / 1.5, max(values) * 1.5)
            f.log_axis(axes.yaxis)
        else:
            axes.set_ylim(0, 1.1 * max(value for _, _, value in placed))
        exact = any(error < f.EXACT for _, error, _ in points)
        axes.set_xlabel("error, pixels, p99" + (" (left edge: none)" if exact else ""))
        axes.set_ylabel(unit)
        axes.set_title(title)
        f.legend(axes, 4)
        labels.write_labels(axes, marks, theme["ink"], line)

    return f.themed(draw, height=3.9)


CHARTS = (
    ("coherent rays", "millions a second, one thread", speed_value("coherent"), False),
    ("incoherent rays", "millions a second, one thread", speed_value("incoherent"), False),
    ("memory", "MiB", lambda row, view: row.bytes / 2**20, True),
)


def scene_charts(data, scene):
    """Its charts, sentences where there is nothing to draw, and the measurements in them."""
    parts, sentences, rows = [], [], []
    for title, unit, value, low in CHARTS:
        points, to_reference = points_of(data, scene, "full", value)
        if len(points) > 1:
            reference = points[0][0].run["settings"]["reference_level"]
            against = f"GRID at level {reference}" if to_reference else f"GRID of the same level, {points[0][0].level}"
            rows += [point[0] for point in points]
            sentence = best_in_words(f"{scene}, {title}, error against {against}", unit, points, low)
            if sentence:
                sentences.append(sentence)
            else:
                name = f"{scene}, {title}: error against\n{against}"
                parts.append(p.chart(chart(name, unit, points, low), f"{title} against error, {scene}"))
    return parts, sentences, rows


def section(data):
    main, body, rows = data.main_scene(), "", []
    for scene in sorted(data.scenes(), key=lambda name: (name != main, name)):
        if len({(row.level, row.label) for row in data.of_scene(scene)}) >= 4:
            parts, sentences, used = scene_charts(data, scene)
            body += (p.charts(parts) if parts else "") + "".join(sentences)
            rows += used
    return p.section(
        "tradeoffs",
        "Speed and memory against error",
        TEXT,
        body or p.missing("several representations of one scene"),
        commands=[row.command for row in rows],
    )
