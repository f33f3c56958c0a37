# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on levels and frame levels: bytes and speed, a row a representation and frame level."""

from html import escape

import report_figures as f
import report_page as p

HEADS = ("bytes a quad", "coherent", "incoherent")
RAY_SETS = ("coherent", "incoherent")
TEXT = (
    "<p>Level L divides a face into 4<sup>L</sup> quads, frame level n divides it into 4<sup>n</sup> blocks with a frame "
    "each: finer frames are tighter and weigh more. Speeds are of single rays, closest hit, one thread, full view, as "
    "how many times GRID's of the same level they are; those of GRID are millions of rays a second.</p>"
)


def speed(row, ray_set):
    """Millions of rays a second of GRID, of the others how many times GRID's. None where not measured."""
    found = row.speed("full", ray_set)
    if not found:
        return None
    return found["mrays_per_second" if row.kind == "GRID" else "relative_to_grid"]["median"]


def cells(row):
    """As text, in the order of HEADS."""
    if not row:
        return ["-"] * len(HEADS)
    speeds = [speed(row, ray_set) for ray_set in RAY_SETS]
    return [f"{row.memory['bytes_per_quad']:.2f}"] + ["-" if s is None else f"{s:.2f}" for s in speeds]


def has_frames(data, scene):
    """Whether a representation was measured at several frame levels."""
    kinds = [kind for kind, _ in {(row.kind, row.frame_level) for row in data.of_scene(scene) if row.frame_level is not None}]
    return len(kinds) > len(set(kinds))


def of_scene(data, scene):
    """Levels, and (representation, cells of each level)."""
    levels = data.levels(scene)
    labels = sorted({row.label for row in data.of_scene(scene)}, key=f.sort_key)
    return levels, [
        (label, [cell for level in levels for cell in cells(data.pick(scene, level, label, "full"))]) for label in labels
    ]


def scenes(data):
    """Those of which there is something to compare, the main scene first."""
    main = data.main_scene()
    found = [scene for scene in data.scenes() if has_frames(data, scene) or len(data.levels(scene)) > 1]
    return sorted(found, key=lambda scene: (scene != main, scene))


def section(data):
    body = ""
    for scene in scenes(data):
        levels, table = of_scene(data, scene)
        rows = [(p.label(label), row) for label, row in table]
        body += f"<h3>{escape(scene)}</h3>" + p.grouped_table([f"level {level}" for level in levels], HEADS, rows)
    return p.section(
        "levels",
        "Levels and frame levels",
        TEXT,
        body or p.missing("several levels or frame levels: scripts/benchmark.py full --job frames_trex"),
        commands=[row.command for scene in scenes(data) for row in data.of_scene(scene)],
    )
