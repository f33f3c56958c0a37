# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on levels and frame levels: bytes and speed, a row a representation and frame level."""

from html import escape

import report_figures as f
import report_page as p

TEXT = (
    "<p>Level L divides a face into 4<sup>L</sup> quads, frame level n divides it into 4<sup>n</sup> blocks with a frame "
    "each: finer frames are tighter and weigh more. Faces that leaves hold badly cLEAF stores exactly, as cVERT does: how much "
    "of it that is stands beside its bytes; cLEAF-only has none. Speeds are of single rays, closest hit, one thread, full view, as "
    "how many times GRID's of the same level they are; those of GRID are millions of rays a second.</p>"
)


def bytes_text(row):
    return f"{row.memory['bytes_per_quad']:.2f}"


def speed_text(ray_set):
    def text(row):
        found = row.speed("full", ray_set)
        return f"{found['mrays_per_second' if row.kind == 'GRID' else 'relative_to_grid']['median']:.2f}" if found else "-"

    return text


def exact_text(row):
    return "-" if row.exact_share is None else f"{100 * row.exact_share:.1f}"


EXACT = "Quads stored exactly, %"
TABLES = {
    "Bytes a quad": bytes_text,
    EXACT: exact_text,
    "Speed, coherent rays": speed_text("coherent"),
    "Speed, incoherent rays": speed_text("incoherent"),
}


def has_frames(data, scene):
    """Whether a representation was measured at several frame levels."""
    kinds = [kind for kind, _ in {(row.kind, row.frame_level) for row in data.of_scene(scene) if row.frame_level is not None}]
    return len(kinds) > len(set(kinds))


def table(data, scene, text):
    """Heads, and a row a representation. text: of a measurement."""
    levels = data.levels(scene)
    labels = sorted({row.label for row in data.of_scene(scene)}, key=f.sort_key)
    rows = [[data.pick(scene, level, label, "full") for level in levels] for label in labels]
    return [f"level {level}" for level in levels], [
        [label, *(text(row) if row else "-" for row in found)] for label, found in zip(labels, rows)
    ]


def tables(data, scene):
    """Titles, heads and rows. How much of cLEAF is stored exactly is a table of cLEAF alone."""
    found = [(title, *table(data, scene, text)) for title, text in TABLES.items()]
    found = [(title, heads, [row for row in rows if title != EXACT or set(row[1:]) != {"-"}]) for title, heads, rows in found]
    return [(title, heads, rows) for title, heads, rows in found if rows]


def scenes(data):
    """Those of which there is something to compare, the main scene first."""
    main = data.main_scene()
    found = [scene for scene in data.scenes() if has_frames(data, scene) or len(data.levels(scene)) > 1]
    return sorted(found, key=lambda scene: (scene != main, scene))


def section(data):
    body = ""
    for scene in scenes(data):
        body += f'<h3>{escape(scene)}</h3><div class="tables">'
        for title, heads, rows in tables(data, scene):
            rows = [[p.label(label), *cells] for label, *cells in rows]
            body += f"<div><h4>{title}</h4>" + p.table(["", *heads], rows, compact=True) + "</div>"
        body += "</div>"
    return p.section(
        "levels",
        "Levels and frame levels",
        TEXT,
        body or p.missing("several levels or frame levels: scripts/benchmark.py full --job 'frames_*'"),
        commands=[row.command for scene in scenes(data) for row in data.of_scene(scene)],
    )
