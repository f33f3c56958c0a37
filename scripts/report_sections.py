# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The sections of the report that show pictures and charts, a function each: from measurements to HTML."""

from html import escape

import report_data as d
import report_figures as f
import report_page as p

BARS = ("NAIVE", "GRID", "cGRID^2", "cGRID^3", "cVOXEL^2", "cVOXEL^3", "cLEAF^2", "cLEAF^3", "cVERT")
HEAT_KEY = "".join(
    f'<span class="entry"><span class="key" style="background:{colour}"></span>{text}</span> '
    for colour, text in (
        ("#2740e0", "none"),
        ("#00d3eb", "1.25 pixels"),
        ("#59e059", "2.5"),
        ("#ffe700", "3.75"),
        ("#ff7cca", "5 and more"),
        ("#000000", "false hit"),
        ("#ff9f00", "miss"),
        ("#ffffff", "background"),
    )
)


def error_lines(errors):
    """RMSE and what it hides."""
    if not errors:
        return ""
    rays = max(1, errors["rays"])
    return (
        f"RMSE <b>{f.error_text(errors['rmse_pixels'])}</b> px, median {f.error_text(errors['median_pixels'])}, "
        f"p99 {f.error_text(errors['p99_pixels'])}; {errors['beyond_5_pixels']} rays beyond 5 px, the others "
        f"{f.error_text(errors['rmse_of_others_pixels'])}; false hits {100 * errors['false_hits'] / rays:.3f}%, "
        f"misses {100 * errors['misses'] / rays:.3f}%"
    )


def error_images(data, wanted):
    """wanted: (scene, level, representation, view)."""
    parts, commands, absent = [], [], []
    for scene, level, name, view in wanted:
        row = data.pick(scene, level, name, view)
        path = row.image(view, "error_map") if row else None
        if not path:
            absent.append(f"{scene}, level {level}, {name}")
            continue
        caption = f"<b>{p.label(name)}</b>, level {level}: {error_lines(row.errors(view))}"
        parts.append(p.image(f.picture(path, 90), caption, f"Error map of {name} at level {level} on {scene}"))
        commands.append(row.command)
    body = f'<div class="pictures three">{"".join(parts)}</div>' if parts else ""
    if absent:
        body += p.missing(("; ".join(absent)) + "; scripts/benchmark.py measures it where the memory is there for it")
    return body + p.command(*commands)


def picture_row(data, scene, level, names, view):
    """Shaded pictures side by side with memory and error."""
    parts, commands = [], []
    grid = data.pick(scene, level, "GRID", view)
    if not any(data.pick(scene, level, name, view) for name in names):
        return p.missing(
            f"{scene} at level {level}, {view} view: run scripts/benchmark.py on a build that has this scene"
        )
    for name in names:
        row = data.pick(scene, level, name, view)
        path = row.image(view, "picture") if row else None
        if not path:
            parts.append(p.missing(f"picture of {scene} in {name}, level {level}, {view} view"))
            continue
        part = f", {100 * row.bytes / grid.bytes:.1f}% of GRID" if grid and name != "GRID" else ""
        size = f"{f.mebibytes(row.bytes)}{part}, {row.memory['bytes_per_quad']:.2f} bytes a quad"
        caption = f"<b>{p.label(name)}</b> {size}"
        if name != "GRID":
            caption += "<br>" + error_lines(row.errors(view))
        parts.append(p.image(f.picture(path, 84), caption, f"{scene} in {name}, {view} view"))
        commands.append(row.command)
    return f'<div class="pictures">{"".join(parts)}</div>' + p.command(*commands)


def commands_of(rows):
    return p.command(*(row.command for row in rows))


def figure_10(data):
    wanted = [("cube", 6, f"{kind}^{n}", "full") for kind in ("cVOXEL", "cLEAF") for n in (2, 3, 4)]
    return p.section(
        "figure10",
        "Figure 10: error over frame levels, cube",
        "<p>Distance between hit points and those of GRID at the same level, level 6, in pixel footprints; local "
        "frames start at level 2, 3 and 4.</p>",
        f'<p class="soft">{HEAT_KEY}</p>',
        error_images(data, wanted),
    )


def figure_11(data):
    main = data.main_scene()
    fine = max([level for level in data.levels(main) if data.pick(main, level, "cVOXEL^4", "close")] or [8])
    wanted = [(main, 6, "cVOXEL^3", "close"), (main, 6, "cLEAF^2", "close"), (main, fine, "cVOXEL^4", "close")]
    return p.section(
        "figure11",
        f"Figure 11: error close up, {main}",
        "<p>The paper's third picture is cVOXEL<sup>4</sup> at level 8, against a mesh of that level; here it is at "
        f"the finest level that was measured, {fine}.</p>",
        f'<p class="soft">{HEAT_KEY}</p>',
        error_images(data, wanted),
    )


def figures_12_to_18(data):
    main = data.main_scene()
    parts = [
        "<p>Memory is what the device holds after the commit, everything included. Magenta are hits whose normal faces "
        "away from the viewer.</p>"
    ]
    for number, scene, names, view in (
        ("12", main, ("GRID", "cVOXEL^3", "cLEAF^2"), "close"),
        ("12, whole", main, ("GRID", "cVOXEL^3", "cLEAF^2"), "full"),
        ("13", "frog", ("GRID", "cVOXEL^3", "cLEAF^2"), "close"),
        ("14", "scythe", ("GRID", "cVOXEL^3", "cLEAF^2"), "close"),
        ("15", "knee", ("GRID", "cVOXEL^3", "cLEAF^2"), "close"),
        ("18, five-fold displacement", "cube:0.45", ("GRID", "cVOXEL^3", "cLEAF^3"), "full"),
    ):
        parts += [f"<h3>Figure {escape(number)}: {escape(scene)}</h3>", picture_row(data, scene, 6, names, view)]
    return p.section("pictures", "Figures 12 to 15 and 18: side by side", *parts)


def figure_16(data):
    main = data.main_scene()
    rows = [row for row in data.of_scene(main) if row.level in (4, 5, 6)]
    levels = sorted({row.level for row in rows})
    names = [name for name in BARS if any(row.label == name for row in rows)]
    charts = []
    for ray_set in ("coherent", "incoherent"):

        def value(label, level, ray_set=ray_set):
            row = data.pick(main, level, label, "full")
            speed = row.speed("full", ray_set) if row else None
            return tuple(speed["mrays_per_second"][key] for key in ("median", "min", "max")) if speed else None

        if any(value(name, level) for name in names for level in levels):
            charts.append(
                p.chart(
                    f.bars_by_level(f"{main}, {ray_set}", "million rays a second, one thread", names, levels, value),
                    f"Speed of each representation, {ray_set} rays",
                )
            )
    if not charts:
        body = p.missing(f"speeds of {main} at levels 4 to 6")
    else:
        body = f'<div class="charts">{"".join(charts)}</div>'
    heads = ["relative to GRID", "min", "mean", "max", "paper: min", "paper: mean", "paper: max"]
    paper = {"cGRID": (65, 84, 99), "cVOXEL": (73, 86, 105), "cLEAF": (69, 80, 92)}
    table = []
    for kind in ("NAIVE", "cGRID", "cVOXEL", "cLEAF", "cVERT"):
        ratios = [100 * r for r in d.relative_speeds(data, kind, main)]
        if ratios:
            ours = (min(ratios), sum(ratios) / len(ratios), max(ratios))
            table.append(
                [kind]
                + [f"{x:.0f}%" for x in ours]
                + [f"{x}%" for x in paper.get(kind, ())]
                + ["-"] * (3 - len(paper.get(kind, ())))
            )
    return p.section(
        "figure16",
        "Figure 16: speed",
        "<p>Primary rays in tiles of 8 x 8 pixels (coherent) and shuffled bounces "
        "with a cosine distribution (incoherent); closest hit, one ray a call. Bars are medians, whiskers "
        "the slowest and the fastest round. The paper's figures are of a Core i7-6700.</p>",
        body,
        p.table(heads, table, stack=True) if table else "",
        commands_of([row for row in rows if row.speeds]),
    )


def figure_17(data):
    main = data.main_scene()
    charts, rows = [], []
    for level in (4, 5, 6):
        here = [row for row in (data.pick(main, level, name) for name in BARS) if row]
        grid = data.pick(main, level, "GRID")
        if here:
            charts.append(p.chart(f.memory_bars(level, here, grid.bytes if grid else 0), f"Memory at level {level}"))
        rows += here
    body = f'<div class="charts">{"".join(charts)}</div>' if charts else p.missing(f"memory of {main} at levels 4 to 6")
    skipped = "".join(f'<p class="missing">{escape(text)}</p>' for text in data.skipped)
    return p.section(
        "figure17",
        "Figure 17: memory",
        f"<p>{escape(main)}; strong colour: inner nodes, frames and everything "
        "else; pale: leaves. Percentages are of GRID. Leaves of NAIVE and GRID are computed from their layout, the "
        "others are counted.</p>",
        body,
        skipped,
        commands_of(rows),
    )


def scatter_points(data, scene, view, value):
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
            points.append((row, errors["rmse_of_others_pixels"], y))
    return points, to_reference


def speed_value(ray_set):
    def value(row, view):
        speed = row.speed(view, ray_set)
        return speed["mrays_per_second"]["median"] if speed else None

    return value


def tradeoffs(data):
    parts, rows = [], []
    for scene in data.scenes():
        if len({(row.level, row.label) for row in data.of_scene(scene)}) < 4:
            continue
        for title, unit, value, low in (
            ("coherent", "Mrays/s", speed_value("coherent"), False),
            ("incoherent", "Mrays/s", speed_value("incoherent"), False),
            ("memory", "MiB", lambda row, view: row.bytes / 2**20, True),
        ):
            points, to_reference = scatter_points(data, scene, "full", value)
            if len(points) > 1:
                settings = points[0][0].run["settings"]
                against = f"GRID at level {settings['reference_level']}" if to_reference else "GRID of the same level"
                parts.append(
                    p.chart(
                        f.scatter(f"{scene}, {title}: error against\n{against}", unit, points, low),
                        f"{title} against error, {scene}",
                    )
                )
                rows += [point[0] for point in points]
    body = f'<div class="charts">{"".join(parts)}</div>' if parts else p.missing("several representations of one scene")
    return p.section(
        "tradeoffs",
        "Speed against error, memory against error",
        "<p>Every representation, level and frame level is a point, larger for higher levels; those on the "
        "Pareto front are labelled with level and, raised, frame level. The error is the RMSE of hits within 5 "
        "pixels: a few rays beyond hit another sheet of the surface, behind a silhouette, and would drown the "
        "others; they are counted under all measurements. Where a scene was measured against a finer reference, the error is that of "
        "tessellation and compression together, and levels can be compared; otherwise it is that of compression "
        "alone, of one level, and GRID has none.</p>",
        body,
        commands_of(rows),
    )


def growth(data):
    names = ("NAIVE", "GRID", "cGRID^2", "cVOXEL^2", "cLEAF^2", "cVERT")
    charts, used = [], []
    for title, unit, value, log_value in (
        ("Memory", "MiB", lambda row: row.bytes / 2**20, True),
        ("Build", "seconds, all threads", lambda row: row.build_seconds, True),
        ("Speed, incoherent", "Mrays/s", lambda row: speed_value("incoherent")(row, "full"), False),
    ):
        lines = {}
        for scene in data.scenes():
            if len(data.levels(scene)) < 2:
                continue
            for name in names:
                rows = [
                    row for row in (data.pick(scene, level, name) for level in data.levels(scene)) if row and value(row)
                ]
                if len(rows) > 1:
                    lines[(name, scene)] = [(row.quads, value(row)) for row in rows]
                    used += rows
        if lines:
            charts.append(p.chart(f.growth(title, unit, lines, log_value), f"{title} over the number of quads"))
    body = f'<div class="charts">{"".join(charts)}</div>' if charts else p.missing("one scene at several levels")
    return p.section("growth", "Growth over the number of quads", body, commands_of(used))
