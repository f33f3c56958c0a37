# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The long tables in Markdown, to be kept beside the program that measured them: memory, speed and error by scene,
level and representation, levels and frame levels, instruction sets, GPUs and the paper's relations."""

import report_data as d
import report_errors
import report_figures as f
import report_gpu as gpu
import report_isas
import report_levels
import report_summary
from report_relations import shown_relations

RAY_SETS = ("coherent", "incoherent")


def table(heads, rows, words=1):
    """words: how many columns, from the left, are of words and not of numbers."""
    lines = ["| " + " | ".join(heads) + " |"]
    lines += ["|" + "|".join(":--" if i < words else "--:" for i in range(len(heads))) + "|"]
    return lines + ["| " + " | ".join(row) + " |" for row in rows] + [""]


def verdict(relation):
    return {True: "holds", False: "does not hold", None: "not measured"}[relation.holds]


def top(data):
    lines = ["# Results", "", "<!-- Made by scripts/report.py of records of scripts/benchmark.py: not written by hand. -->", ""]
    found = report_summary.headline(data)
    if found:
        for figure, *sentences in report_summary.statements(data, found).values():
            lines.append(f"- **{figure}**: {' '.join(filter(None, sentences))}")
        more = report_summary.other_levels(data, found)
        lines += [f"- **Other levels**: {more.replace(' at', ' times smaller at', 1)}."] if more else []
        lines.append("")
    return lines


def run(data):
    """Where and when."""
    lines = []
    for r in {(r["cpu"], r["commit"], r["compiler"], r["flags"]): r for r in data.runs}.values():
        same = [other for other in data.runs if (other["cpu"], other["commit"]) == (r["cpu"], r["commit"])]
        lines.append(
            f"Measured from {d.period(same)} on {r['cpu']} "
            f"({r['hardware_threads']} threads, {r['memory_bytes'] / 2**30:.0f} GiB), commit {r['commit']}, "
            f"{r['compiler']} {r['flags']}."
        )
    found = d.noise(data.rows)
    if found:
        lines.append(f"Noise: a median of ratios to GRID is good to {100 * found['unsure']:.1f}%, 95 of 100 to "
                     f"{100 * found['unsure_95']:.1f}%.")  # fmt: skip
    if data.rows:
        lines.append(
            f"Where nothing else is said, the instruction set is {data.isa}, rays are single ones of one thread, the query "
            "is the closest hit and the view is the full one. Errors are in pixels."
        )
    return lines + [""]


def memory_and_speed(data, scene, rows):
    lines = [f"### {scene}: memory, build and speed", ""]
    heads = ["level", "", "MiB", "bytes a quad", "stored exactly, %", "of GRID", "peak, MiB", "build, s"]
    for ray_set in RAY_SETS:
        heads += [f"{ray_set}, Mrays/s", "of GRID"]
    out = []
    for row in rows:
        grid = data.pick(scene, row.level, "GRID")
        cells = [
            str(row.level),
            row.label,
            f"{row.bytes / 2**20:.2f}",
            f"{row.memory['bytes_per_quad']:.2f}",
            report_levels.exact_text(row),
            f"{100 * row.bytes / grid.bytes:.1f}%" if grid else "-",
            f"{row.memory['peak_bytes'] / 2**20:.1f}",
            f"{row.build_seconds:.2f}",
        ]
        for ray_set in RAY_SETS:
            s = row.speed("full", ray_set)
            cells += (
                [f"{s['mrays_per_second']['median']:.3f}", f"{s['relative_to_grid']['median']:.2f}"] if s else ["-", "-"]
            )
        out.append(cells)
    return lines + table(heads, out, 2)


def errors(scene, rows):
    """Against the mesh, and against the true surface where that was measured. Empty without any."""
    heads = ["level", "", "view", "median", "p99", "rays beyond 5 pixels", "bias of the others", "false hits", "misses"]
    heads += ["normal, degrees", "the paper's RMSE", "true surface: median", "p99"]
    out = []
    for row in rows:
        for view in row.views:
            e, true = row.errors(view), report_errors.true_errors(row, view)
            keys = ("median_pixels", "p99_pixels")
            cells = [str(row.level), row.label, view, *(report_errors.pixels(e[key]) for key in keys)]
            cells += [str(e["beyond_5_pixels"]), f.signed(e["bias_pixels"]), str(e["false_hits"]), str(e["misses"])]
            cells += [f"{e['normal_median_degrees']:.3f}", report_errors.pixels(e["rmse_pixels"])]
            out.append(cells + [report_errors.pixels(true[key]) if true else "-" for key in keys])
    return [f"### {scene}: error", "", *table(heads, out, 3)] if out else []


def scene_part(data, scene):
    rows = sorted(data.of_scene(scene), key=lambda row: (row.level, f.sort_key(row.label)))
    sizes = dict(sorted({row.level: row.quads for row in rows}.items()))
    words = ", ".join(f"{quads:,} at level {level}" for level, quads in sizes.items())
    return [f"## {scene}", "", f"Quads: {words}.", "", *memory_and_speed(data, scene, rows), *errors(scene, rows)]


def grouped(groups, heads, rows):
    return table(["", *(f"{group}: {head}" for group in groups for head in heads)], [[label, *cells] for label, cells in rows])


def levels_part(data):
    lines = []
    for scene in report_levels.scenes(data):
        for title, heads, rows in report_levels.tables(data, scene):
            lines += [f"### {scene}: {title[0].lower() + title[1:]}", "", *table(["", *heads], rows)]
    note = "Speeds are how many times GRID's of the same level they are; those of GRID are millions of rays a second."
    return ["## Levels and frame levels", "", note, "", *lines] if lines else []


def isas_part(data):
    lines = []
    for (scene, level), isas in report_isas.compared(data).items():
        for ray_set in report_isas.RAY_SETS:
            names, rows = report_isas.table(isas, ray_set)
            lines += [f"### {scene}, level {level}, {ray_set}", "", *grouped(names, report_isas.HEADS, rows)]
    where = [f"- {line}" for line in report_isas.machines(data)] + [""] if data.elsewhere else []
    return ["## Instruction sets", "", *where, *lines] if lines else []


def relations_part(data):
    shown = shown_relations(data)
    rows = [[r.claim, r.paper, r.ours, verdict(r) + (": " + r.reason if r.reason else "")] for r in shown]
    if not rows:
        return []
    return ["## The paper's relations", "", *table(["relation", "paper", "ours", "verdict"], rows, 4)]


def gpu_part(data):
    lines = gpu.markdown(data)
    return ["## GPU", "", *lines] if lines else []


def commands_part(data):
    commands = dict.fromkeys(row.command for row in data.rows + data.checked + data.gpu + data.beside_gpu)
    return ["## Commands", "", *(f"    {command}" for command in commands), ""]


def results(data):
    """The whole page."""
    main = data.main_scene()
    lines = top(data) + run(data)
    for scene in sorted(data.scenes(), key=lambda scene: (scene != main, scene)):
        lines += scene_part(data, scene)
    for part in (levels_part, isas_part, gpu_part, relations_part, commands_part):
        lines += part(data)
    return "\n".join(lines)
