#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Makes one self-contained HTML page, and tables in Markdown, of what benchmark.py measured.

    scripts/report.py                              output/benchmark/quick to report.html and tables.md in it
    scripts/report.py DIR --output FILE            another folder of records, another page
    scripts/report.py DIR --against OTHER_DIR      says, too, how far two runs are apart
"""

import argparse
import os
import re
import sys
from html import escape
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import report_data as d  # noqa: E402
import report_figures as f  # noqa: E402
import report_page as p  # noqa: E402
from report_relations import relations  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
BARS = ("NAIVE", "GRID", "cGRID^2", "cGRID^3", "cVOXEL^2", "cVOXEL^3", "cLEAF^2", "cLEAF^3", "cVERT^2", "cVERT^3")
HEAT_KEY = "".join(f'<span class="entry"><span class="key" style="background:{colour}"></span>{text}</span> ' for colour, text in (
    ("#2740e0", "none"), ("#00d3eb", "1.25 pixels"), ("#59e059", "2.5"), ("#ffe700", "3.75"), ("#ff7cca", "5 and more"),
    ("#000000", "false hit"), ("#ff9f00", "miss"), ("#ffffff", "background")))


def error_lines(errors):
    """RMSE and what it hides."""
    if not errors:
        return ""
    rays = max(1, errors["rays"])
    return (f"RMSE <b>{f.error_text(errors['rmse_pixels'])}</b> px, median {f.error_text(errors['median_pixels'])}, "
            f"p99 {f.error_text(errors['p99_pixels'])}; {errors['beyond_5_pixels']} rays beyond 5 px, the others "
            f"{f.error_text(errors['rmse_of_others_pixels'])}; false hits {100 * errors['false_hits'] / rays:.3f}%, "
            f"misses {100 * errors['misses'] / rays:.3f}%")


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
        return p.missing(f"{scene} at level {level}, {view} view: run scripts/benchmark.py on a build that has this scene")
    for name in names:
        row = data.pick(scene, level, name, view)
        path = row.image(view, "picture") if row else None
        if not path:
            parts.append(p.missing(f"picture of {scene} in {name}, level {level}, {view} view"))
            continue
        part = f", {100 * row.bytes / grid.bytes:.1f}% of GRID" if grid and name != "GRID" else ""
        caption = f"<b>{p.label(name)}</b> {row.bytes / 2**20:.2f} MiB{part}, {row.memory['bytes_per_quad']:.2f} bytes a quad"
        if name != "GRID":
            caption += "<br>" + error_lines(row.errors(view))
        parts.append(p.image(f.picture(path, 84), caption, f"{scene} in {name}, {view} view"))
        commands.append(row.command)
    return f'<div class="pictures">{"".join(parts)}</div>' + p.command(*commands)


def commands_of(rows):
    return p.command(*(row.command for row in rows))


def figure_10(data):
    wanted = [("cube", 6, f"{kind}^{n}", "full") for kind in ("cVOXEL", "cLEAF") for n in (2, 3, 4)]
    return p.section("figure10", "Figure 10: error over frame levels, cube",
                     "<p>Distance between hit points and those of GRID at the same level, level 6, in pixel footprints; local "
                     "frames start at level 2, 3 and 4.</p>", f'<p class="soft">{HEAT_KEY}</p>', error_images(data, wanted))


def figure_11(data):
    main = data.main_scene()
    fine = max([level for level in data.levels(main) if data.pick(main, level, "cVOXEL^4", "close")] or [8])
    wanted = [(main, 6, "cVOXEL^3", "close"), (main, 6, "cLEAF^2", "close"), (main, fine, "cVOXEL^4", "close")]
    return p.section("figure11", f"Figure 11: error close up, {main}",
                     "<p>The paper's third picture is cVOXEL<sup>4</sup> at level 8, against a mesh of that level; here it is at "
                     f"the finest level that was measured, {fine}.</p>", f'<p class="soft">{HEAT_KEY}</p>',
                     error_images(data, wanted))


def figures_12_to_18(data):
    main = data.main_scene()
    parts = ["<p>Memory is what the device holds after the commit, everything included.</p>"]
    for number, scene, names, view in (
            ("12", main, ("GRID", "cVOXEL^3", "cLEAF^2"), "close"), ("12, whole", main, ("GRID", "cVOXEL^3", "cLEAF^2"), "full"),
            ("13", "frog", ("GRID", "cVOXEL^3", "cLEAF^2"), "close"), ("14", "scythe", ("GRID", "cVOXEL^3", "cLEAF^2"), "close"),
            ("15", "knee", ("GRID", "cVOXEL^3", "cLEAF^2"), "close"),
            ("18, five-fold displacement", "cube:0.45", ("GRID", "cVOXEL^3", "cLEAF^3"), "full")):
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
            charts.append(p.chart(f.bars_by_level(f"{main}, {ray_set}", "million rays a second, one thread", names, levels, value),
                                  f"Speed of each representation, {ray_set} rays"))
    if not charts:
        body = p.missing(f"speeds of {main} at levels 4 to 6")
    else:
        body = f'<div class="charts">{"".join(charts)}</div>'
    heads = ["relative to GRID", "min", "mean", "max", "paper: min", "mean", "max"]
    paper = {"cGRID": (65, 84, 99), "cVOXEL": (73, 86, 105), "cLEAF": (69, 80, 92)}
    table = []
    for kind in ("NAIVE", "cGRID", "cVOXEL", "cLEAF", "cVERT"):
        ratios = [100 * r for r in d.relative_speeds(data, kind, main)]
        if ratios:
            ours = (min(ratios), sum(ratios) / len(ratios), max(ratios))
            table.append([kind] + [f"{x:.0f}%" for x in ours] + [f"{x}%" for x in paper.get(kind, ())] +
                         ["-"] * (3 - len(paper.get(kind, ()))))
    return p.section("figure16", "Figure 16: speed", "<p>Primary rays in tiles of 8 x 8 pixels (coherent) and shuffled bounces "
                     "with a cosine distribution (incoherent); closest hit, one ray a call. Bars are medians, whiskers "
                     "the slowest and the fastest round. The paper's figures are of a Core i7-6700.</p>",
                     body, p.table(heads, table) if table else "", commands_of([row for row in rows if row.speeds]))


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
    return p.section("figure17", "Figure 17: memory", f"<p>{escape(main)}; dark: inner nodes, frames and everything else; light: "
                     "leaves. Percentages are of GRID. Leaves of NAIVE and GRID are computed from their layout, the "
                     "others are counted.</p>", body, skipped, commands_of(rows))


def scatter_points(data, scene, view, value):
    """(row, error, value) of a scene; and whether errors are against the same level."""
    rows = [row for row in data.of_scene(scene) if row.kind != "NAIVE" and view in row.views]
    to_reference = bool(rows) and all(row.errors(view, True) for row in rows)
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
                ("memory", "MiB", lambda row, view: row.bytes / 2**20, True)):
            points, to_reference = scatter_points(data, scene, "full", value)
            if len(points) > 1:
                settings = points[0][0].run["settings"]
                against = f"GRID at level {settings['reference_level']}" if to_reference else "GRID of the same level"
                parts.append(p.chart(f.scatter(f"{scene}, {title}: error against\n{against}", unit, points, low), f"{title} against error, {scene}"))
                rows += [point[0] for point in points]
    body = f'<div class="charts">{"".join(parts)}</div>' if parts else p.missing("several representations of one scene")
    return p.section("tradeoffs", "Speed against error, memory against error",
                     "<p>Every representation, level and frame level is a point, larger for higher levels; those on the "
                     "Pareto front are labelled with level and, raised, frame level. The error is the RMSE of hits within 5 "
                     "pixels: a few rays beyond hit another sheet of the surface, behind a silhouette, and would drown the "
                     "others; they are counted under all measurements. Where a scene was measured against a finer reference, the error is that of "
                     "tessellation and compression together, and levels can be compared; otherwise it is that of compression "
                     "alone, and GRID has none.</p>", body, commands_of(rows))


def growth(data):
    names = ("NAIVE", "GRID", "cGRID^2", "cVOXEL^2", "cLEAF^2", "cVERT^2")
    charts, used = [], []
    for title, unit, value, log_value in (
            ("Memory", "MiB", lambda row: row.bytes / 2**20, True), ("Build", "seconds, all threads", lambda row: row.build_seconds, True),
            ("Speed, incoherent", "Mrays/s", lambda row: speed_value("incoherent")(row, "full"), False)):
        lines = {}
        for scene in data.scenes():
            if len(data.levels(scene)) < 2:
                continue
            for name in names:
                rows = [row for row in (data.pick(scene, level, name) for level in data.levels(scene)) if row and value(row)]
                if len(rows) > 1:
                    lines[(name, scene)] = [(row.quads, value(row)) for row in rows]
                    used += rows
        if lines:
            charts.append(p.chart(f.growth(title, unit, lines, log_value), f"{title} over the number of quads"))
    body = f'<div class="charts">{"".join(charts)}</div>' if charts else p.missing("one scene at several levels")
    return p.section("growth", "Growth over the number of quads", body, commands_of(used))


def entrances(data):
    rows = [row for row in data.rows if row.job == "entrances" and row.isa == data.isa] or \
           [row for row in data.rows if any(s["mode"] != "single" for s in row.speeds)]
    modes = ("single", "packet4", "packet8", "packet16", "stream")
    heads, table = ["", "set", "query", "threads"] + list(modes), []
    for row in sorted(rows, key=lambda row: (row.scene, row.level, f.sort_key(row.label))):
        for view, ray_set, query, threads in sorted({(s["view"], s["set"], s["query"], s["threads"]) for s in row.speeds}):
            cells = []
            for mode in modes:
                s = row.speed(view, ray_set, query, mode, threads)
                cells.append(f"{s['mrays_per_second']['median']:.2f} <span class=\"soft\">({100 * s['relative_to_grid']['median']:.0f}%)"
                             "</span>" if s else "-")
            table.append([f"{p.label(row.label)} <span class=\"soft\">{escape(row.scene)} L{row.level} {view}</span>", ray_set, query,
                          str(threads)] + cells)
    body = p.table(heads, table, (0, 1, 2)) if table else p.missing("packets and streams: the job 'entrances' of scripts/benchmark.py")
    return p.section("entrances", "Packets, streams and any hit", "<p>Million rays a second through each entrance of the API, and, in "
                     "brackets, relative to GRID through the same.</p>", body, commands_of(rows))


def verdict(relation):
    return {True: '<span class="yes">holds</span>', False: '<span class="no">does not hold</span>',
            None: '<span class="none">not measured</span>'}[relation.holds]


def raised(text):
    """Frame levels raised: cLEAF^2."""
    return re.sub(r"\^(\w+)", r"<sup>\1</sup>", escape(text))


def relation_section(table):
    rows = [[raised(r.claim), escape(r.paper), escape(r.ours), verdict(r)] for r in table]
    return p.section("relations", "The paper's relations", "<p>Memory, error and speed ranges hold when ours are at least as good as "
                     "the paper's; comparisons hold when ours go the same way.</p>",
                     p.table(["relation", "paper", "ours", ""], rows, (0, 1, 2, 3), stack=True),
                     p.command(*(r.row.command for r in table if r.row)))


def details(data):
    heads = ["", "isa", "level", "quads", "MiB", "bytes a quad", "peak MiB", "build s", "view", "RMSE", "median", "p99", "max", "bias",
             "false hits", "misses", "bounces wrong"]
    rows = []
    for row in sorted(data.rows, key=lambda r: (r.scene, r.level, f.sort_key(r.label), r.isa, r.job)):
        for view, found in row.views.items():
            e, b = found["errors"], found["bounced"]
            wrong = 100 * (b["false_hits"] + b["misses"]) / max(1, b["rays"])
            rows.append([f"{escape(row.scene)} {p.label(row.label)}", row.isa, str(row.level), str(row.quads), f"{row.bytes / 2**20:.2f}",
                         f"{row.memory['bytes_per_quad']:.2f}", f"{row.memory['peak_bytes'] / 2**20:.2f}", f"{row.build_seconds:.3f}",
                         escape(view)] + [f.error_text(e[key]) for key in ("rmse_pixels", "median_pixels", "p99_pixels", "max_pixels")] +
                        [f"{e['bias_pixels']:+.4f}", str(e["false_hits"]), str(e["misses"]), f"{wrong:.2f}%"])
    body = p.table(heads, rows) if rows else p.missing("no record could be read")
    return p.section("all", "All measurements", "<details><summary>Memory, build and error of every combination</summary>", body,
                     "</details>")


def noise_text(data, against):
    found = d.noise(data)
    if not found:
        return "<p>No speeds were measured.</p>"
    judged = "quiet" if found["median"] < 0.05 else "noisy: take speeds as rough"
    text = (f"<p><b>Noise.</b> The middle half of the ratios to GRID of a combination spreads by {100 * found['median']:.1f}% (median of "
            f"{found['count']} combinations; the worst {100 * found['max']:.0f}%, {found['beyond']} beyond 5%): {judged}. One "
            "thread is timed by its processor time, so other programs cost caches and clock, not turns.</p>")
    if against is not None:
        apart = d.compare_runs(data, against)
        if apart:
            good = "less than 5%" if apart["beyond"] == 0 else f"{apart['beyond']} of them by more than 5%"
            text += (f"<p><b>Two runs.</b> Medians of ratios to GRID of {apart['count']} combinations differ by {100 * apart['median']:.1f}% "
                     f"(median) and at most {100 * apart['max']:.1f}%: {good}.</p>")
        else:
            text += "<p><b>Two runs.</b> They have no measurement in common.</p>"
    return text


def header(data, against, source):
    def several(values):
        return escape("; ".join(dict.fromkeys(values))) or "-"
    runs = data.runs
    loads = [run["load_before"] for run in runs]
    facts = [("measured", several([f"{min(run['date'] for run in runs)} to {max(run['date'] for run in runs)}"] if runs else [])),
             ("commit", several(run["commit"] for run in runs)),
             ("processor", several(f"{run['cpu']}, {run['hardware_threads']} threads, {run['memory_bytes'] / 2**30:.0f} GiB" for run in runs)),
             ("instruction set", escape(data.isa or "-")),
             ("compiler", several(f"{run['compiler']}, {run['build_type']} {run['flags']}" for run in runs)),
             ("load before", f"{min(loads):.1f} to {max(loads):.1f} runnable threads" if loads else "-"),
             ("records", f"{len(runs)} in <code>{escape(source)}</code>, made by <code>scripts/benchmark.py</code>")]
    text = "<dl>" + "".join(f"<dt>{name}</dt><dd>{value}</dd>" for name, value in facts) + "</dl>"
    text += "".join(f'<p class="missing">{escape(problem)}</p>' for problem in data.problems)
    return "<p>Compressed subdivision surfaces in Embree: the evaluation of Lier, Martinek, Stamminger and Selgrad (2018), made again " \
           "by one command.</p>" + text + noise_text(data, against)


def make_page(data, against, source):
    table = relations(data)
    contents = [("relations", "The paper's relations"), ("figure10", "Figure 10"), ("figure11", "11"), ("pictures", "12 to 15, 18"),
                ("figure16", "16"), ("figure17", "17"), ("tradeoffs", "Speed, memory and error"), ("growth", "Growth"),
                ("entrances", "Packets"), ("all", "All")]
    sections = [relation_section(table), figure_10(data), figure_11(data), figures_12_to_18(data), figure_16(data), figure_17(data),
                tradeoffs(data), growth(data), entrances(data), details(data)]
    return p.page("Embree CBVH: benchmark report", header(data, against, source), sections, contents)


def make_tables(data):
    """For the README: memory, error and speed of the main scene; the relations."""
    main = data.main_scene()
    lines = []
    for level in data.levels(main):
        rows = sorted((row for row in data.of_scene(main) if row.level == level), key=lambda row: f.sort_key(row.label))
        grid = data.pick(main, level, "GRID")
        lines += [f"{main}, level {level}, {rows[0].quads / 1e6:.2f} million quads", "",
                  "| | bytes a quad | of GRID | build, s | RMSE, pixels | coherent, Mrays/s | of GRID | incoherent, Mrays/s | of GRID |",
                  "|:--|--:|--:|--:|--:|--:|--:|--:|--:|"]
        for row in rows:
            cells = [row.label, f"{row.memory['bytes_per_quad']:.2f}", f"{100 * row.bytes / grid.bytes:.0f}%" if grid else "-",
                     f"{row.build_seconds:.2f}", f.error_text(row.errors("full")["rmse_pixels"]) if row.errors("full") else "-"]
            for ray_set in ("coherent", "incoherent"):
                s = row.speed("full", ray_set)
                cells += [f"{s['mrays_per_second']['median']:.2f}", f"{100 * s['relative_to_grid']['median']:.0f}%"] if s else ["-", "-"]
            lines.append("| " + " | ".join(cells) + " |")
        lines.append("")
    lines += ["| relation | paper | ours | |", "|:--|:--|:--|:--|"]
    for r in relations(data):
        lines.append(f"| {r.claim} | {r.paper} | {r.ours} | {'holds' if r.holds else 'not measured' if r.holds is None else 'does not hold'} |")
    return "\n".join(lines) + "\n"


def write(path, text):
    """Whole or not at all."""
    temporary = path.with_name(f".tmp-{os.getpid()}-{path.name}")
    try:
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(path)
    except OSError as error:
        raise SystemExit(f"report.py: {path}: cannot be written: {error.strerror}") from error


def read(folder):
    if not Path(folder).is_dir():
        raise SystemExit(f"report.py: {folder}: no such folder; scripts/benchmark.py makes it")
    data = d.Data(folder)
    if not data.rows and not data.problems:
        raise SystemExit(f"report.py: {folder}: no measurements in it; scripts/benchmark.py makes them")
    for problem in data.problems:
        print(f"report.py: warning: {problem}; left out", file=sys.stderr)
    return data


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", nargs="?", default=str(ROOT / "output/benchmark/quick"), metavar="DIR", help="records of benchmark.py")
    parser.add_argument("--output", metavar="FILE", help="the page (default: report.html in DIR)")
    parser.add_argument("--tables", metavar="FILE", help="tables in Markdown (default: tables.md beside the page)")
    parser.add_argument("--against", metavar="DIR", help="records of another run on the same machine")
    options = parser.parse_args()
    data = read(options.folder)
    against = read(options.against) if options.against else None
    output = Path(options.output) if options.output else Path(options.folder) / "report.html"
    tables = Path(options.tables) if options.tables else output.with_name("tables.md")
    write(output, make_page(data, against, Path(options.folder).name))
    write(tables, make_tables(data))
    print(f"{output} ({output.stat().st_size / 2**20:.1f} MiB), {tables}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
