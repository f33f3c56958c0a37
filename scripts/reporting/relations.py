# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Compares claims of the paper (Lier, Martinek, Stamminger, Selgrad 2018) with measurements. The paper's cLEAF, with
leaves for all faces, is cLEAF-only here."""

from collections import namedtuple

from .data import MAIN_SCENE
from .formats import Table, mib

LEAF, VOXEL2, VOXEL3, VOXEL4 = "cLEAF-only^2", "cVOXEL^2", "cVOXEL^3", "cVOXEL^4"
RELATIVE_SPEEDS = ["coherent_of_grid", "incoherent_of_grid"]
VALUES = {  # compared value: column, format
    "memory": ("mib", "{:.1f} against {:.1f} MiB"), "RMSE": ("errors_rmse_pixels", "{:.3f} against {:.3f} pixels"),
    "p99": ("errors_p99_pixels", "{:.3f} against {:.3f} pixels"),
}  # fmt: skip
# holds: None if it was not measured; reason: why it does not hold, or "" if the reason is unknown
Relation = namedtuple("Relation", "claim paper ours holds reason", defaults=("not measured", None, ""))


def part_of_grid(data, scene, label, paper, level=6):
    """Holds if the percentage is not larger than the paper's, rounded to the same digits."""
    none = Relation(f"{scene}: memory of {label} at level {level} as a part of GRID at level 6", f"{paper}%")
    ours, grid = data.pick(scene, level, label), data.pick(scene, 6, "GRID")
    if ours is None or grid is None:
        return none
    value, step = 100 * ours.mib / grid.mib, 0.5 if isinstance(paper, int) else 0.05
    text = f"{value:.1f}% ({mib(ours.memory_live_bytes)} of {mib(grid.memory_live_bytes)})"
    return none._replace(ours=text, holds=value <= paper + step)


def is_smaller(data, scene, view, first, second, what, paper, reason=lambda a, b: ""):
    """Holds if a value of the first (level, label) is below the value of the second. reason: function of both rows."""
    column, form = VALUES[what]
    claim = f"{what} of {first[1]} at level {first[0]} is below that of {second[1]} at level {second[0]}"
    none = Relation(f"{scene}, {view} view: {claim}", paper)
    a, b = data.pick(scene, *first, view), data.pick(scene, *second, view)
    if a is None or b is None:
        return none
    text = form.format(a[column], b[column])
    return none._replace(ours=text, holds=a[column] < b[column], reason=reason(a, b))


def ratios(data, kind, scene, levels=(4, 5, 6), frame_levels=(2, 3)):
    """Speeds in percent of GRID's, single rays, closest hit, both ray sets. The paper used frame levels 2 and 3."""
    rows = data.full[(data.full.scene == scene) & (data.full.kind == kind) & data.full.level.isin(levels)]
    rows = rows[rows.frame_level.isin(frame_levels) | rows.frame_level.isna()]
    return 100 * rows[RELATIVE_SPEEDS].stack()


def covers_levels(data, kind, scene, frame_levels=(2, 3)):
    """True if both ray sets were measured at each of levels 4 to 6. A mean over fewer is not the paper's."""
    return all(
        set(ratios(data, kind, scene, (level,), frame_levels).index.get_level_values(-1)) == set(RELATIVE_SPEEDS)
        for level in (4, 5, 6)
    )


def speed_range(data, scene, kind, low, high, mean):
    claim = f"{scene}: speed of {kind} in percent of GRID's, coherent and incoherent, levels 4 to 6"
    found, none = ratios(data, kind, scene), Relation(claim, f"{low} to {high}%, mean {mean}%")
    if not covers_levels(data, kind, scene):
        return none
    text = f"{found.min():.0f} to {found.max():.0f}%, mean {found.mean():.0f}%"
    return none._replace(ours=text, holds=found.mean() >= mean)


def fine_frames(data, scene):
    """For cVOXEL^4 at the measured levels; the paper measured level 8."""
    levels = [level for level in data.levels(scene) if data.pick(scene, level, VOXEL4) is not None]
    measured = f"at level {', '.join(map(str, levels))} " if levels else ""
    claim = f"{scene}: {VOXEL4} {measured}is slower than {LEAF} at levels 4 to 6, relative to GRID"
    found = {frames: ratios(data, "cVOXEL", scene, levels, (frames,)).mean() for frames in (2, 4)}
    coarse, none = ratios(data, "cLEAF-only", scene, frame_levels=(2,)).mean(), Relation(claim, "mean 68% against 80%")
    if not (found[4] > 0 and covers_levels(data, "cLEAF-only", scene, (2,))):
        return none
    reason = f"{VOXEL4} has {100 * found[4] / found[2]:.0f}% of the speed of {VOXEL2} here" if found[2] > 0 else ""
    return none._replace(ours=f"mean {found[4]:.0f}% against {coarse:.0f}%", holds=found[4] < coarse, reason=reason)


def blocks_cost_little(leaf, voxel):
    """Returns the reason why leaves require more memory than four times as many blocks."""
    few, many = (row.memory_compression_header_bytes + row.memory_compression_top_level_bytes for row in (leaf, voxel))
    return (
        f"a block has {many / voxel.memory_compression_blocks:.0f} bytes of frame and upper tree here, so finer frames "
        f"of {VOXEL3} add {mib(many - few)}, and the leaves of {LEAF} {mib(leaf.memory_compression_leaf_bytes)}"
    )


def relations(data):
    """Returns what the paper states about its scenes, measured or not; nothing for a user's cages."""
    if data.is_own():
        return []
    main = MAIN_SCENE
    return [
        part_of_grid(data, main, LEAF, 20),
        part_of_grid(data, main, VOXEL2, 10),
        is_smaller(data, main, "full", (6, LEAF), (6, VOXEL3), "memory", "94 against 101.4 MiB", blocks_cost_little),
        is_smaller(data, main, "close", (6, LEAF), (6, VOXEL3), "RMSE", "0.064 against 0.146 pixels"),
        is_smaller(data, main, "close", (6, LEAF), (6, VOXEL3), "p99", "not given"),
        is_smaller(data, main, "close", (6, LEAF), (8, VOXEL4), "RMSE", "0.064 against 0.093 pixels"),
        is_smaller(data, main, "close", (6, LEAF), (8, VOXEL4), "memory", "94 against 555 MiB"),
        is_smaller(data, "cube", "full", (6, LEAF), (6, VOXEL4), "RMSE", "by the colors of figure 10"),
        part_of_grid(data, "cube", LEAF, 31.3),
        part_of_grid(data, "cube", VOXEL2, 41.6, 7),
        speed_range(data, main, "cGRID", 65, 99, 84),
        speed_range(data, main, "cVOXEL", 73, 105, 86),
        speed_range(data, main, "cLEAF-only", 69, 92, 80),
        fine_frames(data, main),
    ]


def verdict(relation):
    if relation.holds is None:
        return "not measured"
    return "holds" if relation.holds else f"does not hold: {relation.reason or 'the reason is not known'}"


def section(data):
    rows = [[relation.claim, relation.paper, relation.ours, verdict(relation)] for relation in relations(data)]
    return [Table(["relation", "paper", "ours", "verdict"], rows, 4)] if rows else []
