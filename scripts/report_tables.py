# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The sections of the report that are tables."""

from html import escape

import report_figures as f
import report_levels as levels
import report_page as p


def entrances(data):
    rows = [row for row in data.rows if row.job in ("entrances", "threads") and row.isa == data.isa] or [
        row for row in data.rows if any(s["mode"] != "single" for s in row.speeds)
    ]
    modes = ("single", "packet4", "packet8", "packet16", "stream")
    heads, table = ["", "set", "query", "threads"] + list(modes), []
    for row in sorted(rows, key=lambda row: (row.scene, row.level, f.sort_key(row.label))):
        for view, ray_set, query, threads in sorted(
            {(s["view"], s["set"], s["query"], s["threads"]) for s in row.speeds}
        ):
            cells = []
            for mode in modes:
                s = row.speed(view, ray_set, query, mode, threads)
                cells.append(
                    f"{s['mrays_per_second']['median']:.2f} <span class=\"soft\">({100 * s['relative_to_grid']['median']:.0f}%)"
                    "</span>"
                    if s
                    else "-"
                )
            table.append(
                [
                    f'{p.label(row.label)} <span class="soft">{escape(row.scene)} L{row.level} {view}</span>',
                    ray_set,
                    query,
                    str(threads),
                ]
                + cells
            )
    body = (
        p.table(heads, table, (0, 1, 2))
        if table
        else p.missing("packets and streams: the job 'entrances' of scripts/benchmark.py")
    )
    return p.section(
        "entrances",
        "Packets, streams and any hit",
        "<p>Million rays a second through each entrance of the API, and, in "
        "brackets, relative to GRID through the same.</p>",
        body,
        commands=[row.command for row in rows],
    )


def verdict(holds):
    return {
        True: '<span class="yes">holds</span>',
        False: '<span class="no">does not hold</span>',
        None: '<span class="none">not measured</span>',
    }[holds]


def reason(relation):
    return f'<span class="reason">{p.raised(relation.reason)}</span>' if relation.reason else ""


def relation_section(table):
    rows = [[p.raised(r.claim), escape(r.paper), escape(r.ours), verdict(r.holds) + reason(r)] for r in table]
    return p.section(
        "relations",
        "The paper's relations",
        "<p>Parts of GRID and speeds hold when ours are at least as good as "
        "the paper's; comparisons hold when ours go the same way.</p>",
        p.table(["relation", "paper", "ours", "verdict"], rows, (0, 1, 2, 3))
        if rows
        else p.missing("scenes of the paper"),
        commands=[r.row.command for r in table if r.row],
    )


def in_order(data):
    return sorted(data.rows, key=lambda r: (r.scene, r.level, f.sort_key(r.label), r.isa, r.job))


def builds(data):
    heads = ["", "instruction set", "level", "quads", "MiB", "bytes a quad", "stored exactly, %", "peak, MiB", "build, s"]
    rows = [
        [
            f"{escape(row.scene)} {p.label(row.label)}",
            row.isa,
            str(row.level),
            str(row.quads),
            f"{row.bytes / 2**20:.2f}",
            f"{row.memory['bytes_per_quad']:.2f}",
            levels.exact_text(row),
            f"{row.memory['peak_bytes'] / 2**20:.2f}",
            f"{row.build_seconds:.3f}",
        ]
        for row in in_order(data)
    ]
    return rows_of_all("Memory and build", heads, rows)


def errors(data):
    heads = ["", "instruction set", "level", "view", "median", "p99", "max", "the paper's RMSE", "bias", "false hits"]
    rows = []
    for row in in_order(data):
        for view, found in row.views.items():
            e, b = found["errors"], found["bounced"]
            wrong = 100 * (b["false_hits"] + b["misses"]) / max(1, b["rays"])
            rows.append(
                [f"{escape(row.scene)} {p.label(row.label)}", row.isa, str(row.level), escape(view)]
                + [f.error_text(e[key]) for key in ("median_pixels", "p99_pixels", "max_pixels", "rmse_pixels")]
                + [f.signed(e["bias_pixels"]), str(e["false_hits"]), str(e["misses"]), f"{wrong:.2f}%"]
            )
    return rows_of_all("Error", [*heads, "misses", "bounces wrong"], rows)


def speeds(data):
    heads = ["", "instruction set", "level", "view", "rays", "query", "entrance", "threads", "Mrays/s"]
    rows = []
    for row in in_order(data):
        for s in row.speeds:
            ratio = s["relative_to_grid"]
            rows.append(
                [f"{escape(row.scene)} {p.label(row.label)}", row.isa, str(row.level), escape(s["view"])]
                + [s[key] for key in ("set", "query", "mode")]
                + [str(s["threads"]), f"{s['mrays_per_second']['median']:.3f}"]
                + [f"{100 * ratio['median']:.1f}%", f"{100 * ratio['spread']:.1f}%", str(len(s["seconds"]))]
            )
    return rows_of_all("Speed, and how far its ratios to GRID spread", [*heads, "of GRID", "spread", "rounds"], rows)


def rows_of_all(title, heads, rows):
    body = p.table(heads, rows) if rows else p.missing("no record could be read")
    return p.folded(f"{title}, every combination", body)


def all_measurements(data):
    return p.section("all", "All measurements", builds(data), errors(data), speeds(data))
