# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""What the paper (Lier, Martinek, Stamminger, Selgrad 2018) claims, held against our measurements. Its cLEAF has leaves for all
faces: here that is cLEAF-only."""

from report_data import relative_speeds
from report_figures import mebibytes


class Relation:
    """claim, the paper's value, ours as text, and whether it holds: None when it was not measured. reason: why it does
    not, where that is known."""

    def __init__(self, claim, paper, ours="not measured", holds=None, row=None, reason=""):
        self.claim, self.paper, self.ours, self.holds, self.row = claim, paper, ours, holds, row
        self.reason = "" if holds is not False else reason or "the reason is not known"


def percent(part, whole):
    return 100.0 * part / whole


def part_of_grid(data, claim, paper, bound, scene, label, level=6):
    ours, grid = data.pick(scene, level, label), data.pick(scene, 6, "GRID")
    if not ours or not grid:
        return Relation(claim, paper)
    value = percent(ours.bytes, grid.bytes)
    return Relation(
        claim, paper, f"{value:.1f}% ({mebibytes(ours.bytes)} of {mebibytes(grid.bytes)})", value <= bound, ours
    )


def below(data, claim, paper, scene, view, first, second, get, unit, form="{:.3f}", reason=None):
    """first, second: (level, label); holds when get(first) < get(second). reason: of both rows."""
    a, b = data.pick(scene, first[0], first[1], view), data.pick(scene, second[0], second[1], view)
    x, y = (get(a) if a else None), (get(b) if b else None)
    if x is None or y is None:
        return Relation(claim, paper)
    text = f"{form.format(x)} against {form.format(y)} {unit}"
    return Relation(claim, paper, text, x < y, a, reason(a, b) if reason else "")


def rmse(view):
    def get(row):
        errors = row.errors(view)
        return errors["rmse_pixels"] if errors else None

    return get


def p99(view):
    def get(row):
        errors = row.errors(view)
        return errors["p99_pixels"] if errors else None

    return get


def speed_range(data, scene, kind, low, high, mean):
    claim = f"Speed of {kind} relative to GRID, coherent and incoherent, levels 4 to 6"
    paper = f"{low} to {high}%, mean {mean}%"
    ratios = [100 * r for r in relative_speeds(data, kind, scene)]
    if not ratios:
        return Relation(claim, paper)
    ours = sum(ratios) / len(ratios)
    row = next(r for r in data.of_scene(scene) if r.kind == kind)
    return Relation(claim, paper, f"{min(ratios):.0f} to {max(ratios):.0f}%, mean {ours:.0f}%", ours >= mean, row)


def fine_frames_are_slower(data, scene):
    """The paper has cVOXEL^4 at level 8; ours is of the levels that were measured."""
    levels = tuple(level for level in data.levels(scene) if data.pick(scene, level, "cVOXEL^4"))
    listed = ", ".join(map(str, levels)) or "-"
    claim = f"{scene}: cVOXEL^4 (levels {listed}) is slower than cLEAF-only^2 (levels 4 to 6), relative to GRID"
    paper = "mean 68% (level 8) against 80%"
    fine = relative_speeds(data, "cVOXEL", scene, levels, frame_levels=(4,))
    coarse = relative_speeds(data, "cLEAF-only", scene, frame_levels=(2,))
    if not fine or not coarse:
        return Relation(claim, paper)
    a, b = percent(sum(fine), len(fine)), percent(sum(coarse), len(coarse))
    text = f"mean {a:.0f}% against {b:.0f}%"
    return Relation(claim, paper, text, a < b, data.pick(scene, levels[-1], "cVOXEL^4"), frames_cost_a_ray(data, scene, levels, a))


def frames_cost_a_ray(data, scene, levels, fine):
    """fine: mean speed of cVOXEL^4, in percent of GRID's."""
    coarse = relative_speeds(data, "cVOXEL", scene, levels, frame_levels=(2,))
    if not coarse:
        return ""
    return f"frames cost a ray less here: cVOXEL^4 has {percent(fine, percent(sum(coarse), len(coarse))):.0f}% of the speed of cVOXEL^2"


def blocks_cost_little(leaf, voxel):
    """cVOXEL with four times the blocks of cLEAF-only: what the blocks cost beside nodes and leaves."""

    def outside(row):
        parts = row.memory["compression"]
        return parts["frame_bytes"] + parts["top_level_bytes"], parts["blocks"]

    (few, _), (many, blocks) = outside(leaf), outside(voxel)
    leaves = leaf.memory["compression"]["leaf_bytes"]
    return (
        f"a block takes {many / blocks:.0f} bytes of frame and upper tree here, so that the finer frames of {voxel.label} add "
        f"{mebibytes(many - few)}, and the leaves of {leaf.label} {mebibytes(leaves)}"
    )


def relations(data):
    main = data.main_scene()
    has_level8 = data.pick(main, 8, "cVOXEL^4") is not None
    fine_scene = main if has_level8 else "cube"
    fine_view = "close" if has_level8 else "full"
    of = "" if has_level8 else "of its T-rex: "
    table = [
        part_of_grid(data, f"{main}: memory of cLEAF-only^2 as a part of GRID, level 6", "20%", 20.5, main, "cLEAF-only^2"),
        part_of_grid(data, f"{main}: memory of cVOXEL^2 as a part of GRID, level 6", "10%", 10.5, main, "cVOXEL^2"),
        below(
            data,
            f"{main}: cLEAF-only^2 takes less memory than cVOXEL^3, level 6",
            "94 against 101.4 MiB",
            main,
            None,
            (6, "cLEAF-only^2"),
            (6, "cVOXEL^3"),
            lambda row: row.bytes / 2**20,
            "MiB",
            "{:.1f}",
            blocks_cost_little,
        ),
        below(
            data,
            f"{main}, close view: RMSE of cLEAF-only^2 is below that of cVOXEL^3, level 6",
            "0.064 against 0.146 pixels",
            main,
            "close",
            (6, "cLEAF-only^2"),
            (6, "cVOXEL^3"),
            rmse("close"),
            "pixels",
        ),
        below(
            data,
            f"{main}, close view: so is its p99, which 99 of 100 hits stay below",
            "not given",
            main,
            "close",
            (6, "cLEAF-only^2"),
            (6, "cVOXEL^3"),
            p99("close"),
            "pixels",
        ),
        below(
            data,
            f"{fine_scene}, {fine_view} view: RMSE of cLEAF-only^2 at level 6 is below that of cVOXEL^4 at level 8",
            of + "0.064 against 0.093 pixels",
            fine_scene,
            fine_view,
            (6, "cLEAF-only^2"),
            (8, "cVOXEL^4"),
            rmse(fine_view),
            "pixels",
        ),
        below(
            data,
            f"{fine_scene}: cLEAF-only^2 at level 6 takes less memory than cVOXEL^4 at level 8",
            of + "94 against 555 MiB",
            fine_scene,
            None,
            (6, "cLEAF-only^2"),
            (8, "cVOXEL^4"),
            lambda row: row.bytes / 2**20,
            "MiB",
        ),
        below(
            data,
            "cube: RMSE of cLEAF-only^2 is below that of cVOXEL^4, level 6",
            "by the colours of figure 10",
            "cube",
            "full",
            (6, "cLEAF-only^2"),
            (6, "cVOXEL^4"),
            rmse("full"),
            "pixels",
        ),
        part_of_grid(
            data, "cube: memory of cLEAF-only^2 at level 6 as a part of GRID at level 6", "31.3%", 31.35, "cube", "cLEAF-only^2"
        ),
        part_of_grid(
            data,
            "cube: memory of cVOXEL^2 at level 7 as a part of GRID at level 6",
            "41.6%",
            41.65,
            "cube",
            "cVOXEL^2",
            7,
        ),
        speed_range(data, main, "cGRID", 65, 99, 84),
        speed_range(data, main, "cVOXEL", 73, 105, 86),
        speed_range(data, main, "cLEAF-only", 69, 92, 80),
        fine_frames_are_slower(data, main),
    ]
    return table


def shown_relations(data):
    """All of them, but of one's own cage those that were measured."""
    return [r for r in relations(data) if r.holds is not None or not data.is_own()]
