# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on leaks, crossed sheets and self-shadowing."""

from html import escape

import report_figures as f
import report_page as p


def order(row):
    return (row.scene, row.run["settings"]["position"], row.level, f.sort_key(row.label), row.job)


def where(row):
    position = row.run["settings"]["position"]
    far = " at " + ", ".join(f"{x:.0f}" for x in position) if any(position) else ""
    return f'{p.label(row.label)} <span class="soft">{escape(row.scene)} L{row.level}{far}</span>'


def leaks_table(rows):
    table = []
    for row in rows:
        found, grid = row.leaks["missed"], row.leaks["missed_by_grid"]
        table.append(
            [where(row), f"{row.leaks['rays']:,}"]
            + [str(found[key]) for key in ("closest", "any", "through")]
            + [str(grid[key]) for key in ("closest", "any", "through")]
        )
    return p.table(["", "rays", "closest", "any hit", "through", "GRID: closest", "GRID: any hit", "GRID: through"], table)


def sheets_table(rows):
    table = [
        [p.label(row.label)] + [f"{row.sheets[key]:,}" for key in ("sheets", "rays", "closest", "any", "missed_by_grid")]
        for row in rows
    ]
    return p.table(["", "sheets", "rays", "closest", "any hit", "GRID, too"], table)


def share(errors, rays):
    """Both kinds of errors, of a thousand rays."""
    return f"{1000 * (errors['false_occlusions'] + errors['false_passes']) / max(1, rays):.3f}"


def shadows_table(rows):
    table = []
    for row in rows:
        for s in row.shadows:
            n = max(1, s["rays"])
            table.append(
                [where(row), escape(s["offset"]), "infinite" if s["length"] is None else "short", share(s["errors"], n)]
                + [f"{1000 * s['errors'][key] / n:.3f}" for key in ("false_occlusions", "false_passes")]
                + [
                    share(s["same_place_errors"], s["same_place_rays"]),
                    share(s["turned_errors"], n),
                    share(s["control_errors"], n),
                ]
            )
    heads = ["", "offset", "rays", "wrong", "dark", "bright", "same place", "turned", "control"]
    return p.table(heads, table, (0, 1, 2))


LEAKS = (
    "<p>Rays from inside of closed surfaces; three of four aim at vertices and edges of quads, at borders of "
    "blocks and faces, straight on or grazing. They start farther from the surface than it is thick. "
    "<i>Closest</i> and <i>any hit</i> count rays that find nothing, <i>through</i> those that pass the wall in "
    "front of them and hit the outside of another. cGRID tests GRID's triangles, which let some rays slip "
    "between them; both do.</p>"
)
SHEETS = (
    "<p>Rays from one side of a displaced sheet to the other, each of which has to hit it: sheets of random "
    "amplitude, sideways displacement, frequency, level, frame level and edge rates, with GRID as the judge. "
    "<i>GRID, too</i> counts rays that GRID lets through as well.</p>"
)
SHADOWS = (
    "<p>Secondary rays with a cosine distribution from the hits of primary rays, each representation's own, "
    "against GRID's from GRID's hits: of a thousand, how many are <i>wrong</i>: dark where GRID has light, or "
    "bright. <i>Same place</i>: of those whose primary hits agree to a pixel. <i>Turned</i>: the part of wrong "
    "ones that starts at a normal which is seen from behind. <i>Control</i>: GRID's rays from the "
    "representation's hits. <i>Short</i> rays end after a tenth of the diagonal.</p>"
)
BY_CHECKS = "jobs of scripts/benchmark.py whose names begin with checks"
PARTS = (
    ("leaks", LEAKS, leaks_table, "leaks: " + BY_CHECKS),
    ("sheets", SHEETS, sheets_table, "crossed sheets: job checks_sheets of scripts/benchmark.py"),
    ("shadows", SHADOWS, shadows_table, "shadows: " + BY_CHECKS),
)


def robustness(data):
    """Of one's own cage only the parts that were measured."""
    rows = sorted(data.checked, key=order)
    body = []
    for what, text, table, absent in PARTS:
        found = [row for row in rows if getattr(row, what)]
        if found or not data.is_own():
            body += [text, table(found) if found else p.missing(absent)]
    body = body or [p.missing(BY_CHECKS)]
    return p.section("robustness", "Leaks and self-shadowing", *body, commands=[row.command for row in rows])
