# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The paper's figures 10 to 16 and 18, a function each: from measurements to HTML. Figure 17 is in report_memory.py. Errors are
the paper's RMSE, and beside it what it hides. The paper's cLEAF is cLEAF-only here, as the library's stores faces exactly."""

from html import escape

import report_data as d
import report_figures as f
import report_page as p

BARS = ("NAIVE", "GRID", "cGRID^2", "cGRID^3", "cVOXEL^2", "cVOXEL^3", "cLEAF-only^2", "cLEAF-only^3", "cVERT")
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
    """The paper's RMSE, and what it hides."""
    if not errors:
        return ""
    rays = max(1, errors["rays"])
    return (
        f"RMSE <b>{f.error_text(errors['rmse_pixels'])}</b> px, median {f.error_text(errors['median_pixels'])}, "
        f"p99 {f.error_text(errors['p99_pixels'])}; {errors['beyond_5_pixels']} rays beyond 5 px; false hits {100 * errors['false_hits'] / rays:.3f}%, "
        f"misses {100 * errors['misses'] / rays:.3f}%"
    )


def error_images(data, wanted):
    """wanted: (scene, level, representation, view). HTML, and the commands that made it."""
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
    return body, commands


def picture_row(data, scene, level, names, view):
    """Shaded pictures side by side with memory and error: HTML, and the commands that made it."""
    parts, commands = [], []
    grid = data.pick(scene, level, "GRID", view)
    if not any(data.pick(scene, level, name, view) for name in names):
        return p.missing(
            f"{scene} at level {level}, {view} view; scripts/benchmark.py measures it"
        ), []
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
    return f'<div class="pictures">{"".join(parts)}</div>', commands


def figure_10(data):
    wanted = [("cube", 6, f"{kind}^{n}", "full") for kind in ("cVOXEL", "cLEAF-only") for n in (2, 3, 4)]
    images, commands = error_images(data, wanted)
    return p.section(
        "figure10",
        "Figure 10: error over frame levels, cube",
        "<p>Distance between hit points and those of GRID at the same level, level 6, in pixel footprints; local "
        "frames start at level 2, 3 and 4.</p>",
        f'<p class="soft">{HEAT_KEY}</p>',
        images,
        commands=commands,
    )


def figure_11(data):
    main = data.main_scene()
    fine = max([level for level in data.levels(main) if data.pick(main, level, "cVOXEL^4", "close")] or [8])
    level = data.picture_level()
    shown = ((level, "cVOXEL^3"), (level, "cLEAF-only^2"), (fine, "cVOXEL^4"))
    wanted = [(main, of, name, "close") for of, name in shown]
    if data.is_own():
        wanted = [picture for picture in wanted if data.pick(*picture)]
    images, commands = error_images(data, wanted)
    return p.section(
        "figure11",
        f"Figure 11: error close up, {main}",
        "<p>The paper's third picture is cVOXEL<sup>4</sup> at level 8, against a mesh of that level; here it is at "
        f"the finest level that was measured, {fine}.</p>",
        f'<p class="soft">{HEAT_KEY}</p>',
        images,
        commands=commands,
    )


def figures_12_to_18(data):
    main, commands = data.main_scene(), []
    parts = [
        "<p>Memory is what the device holds after the commit, everything included. Shading is by the normals of the hits, "
        "alike from both sides; how many are flipped stands among the errors.</p>"
    ]
    for number, scene, names, view in (
        ("12", main, ("GRID", "cVOXEL^3", "cLEAF-only^2"), "close"),
        ("12, whole", main, ("GRID", "cVOXEL^3", "cLEAF-only^2"), "full"),
        ("13", "frog", ("GRID", "cVOXEL^3", "cLEAF-only^2"), "close"),
        ("14", "scythe", ("GRID", "cVOXEL^3", "cLEAF-only^2"), "close"),
        ("15", "knee", ("GRID", "cVOXEL^3", "cLEAF-only^2"), "close"),
        ("18, five-fold displacement", "cube:0.45", ("GRID", "cVOXEL^3", "cLEAF-only^3"), "full"),
    ):
        if data.is_own() and scene != main:
            continue
        row, made_by = picture_row(data, scene, data.picture_level(), names, view)
        parts += [f"<h3>Figure {escape(number)}: {escape(scene)}</h3>", row]
        commands += made_by
    return p.section("pictures", "Figures 12 to 15 and 18: side by side", *parts, commands=commands)


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
        body = p.charts(charts)
    heads = ["relative to GRID", "min", "mean", "max", "paper: min", "paper: mean", "paper: max"]
    paper = {"cGRID": (65, 84, 99), "cVOXEL": (73, 86, 105), "cLEAF-only": (69, 80, 92)}
    table = []
    for kind in ("NAIVE", "cGRID", "cVOXEL", "cLEAF-only", "cVERT"):
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
        p.table(heads, table) if table else "",
        commands=[row.command for row in rows if row.speeds],
    )
