# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Charts of speed and memory against error, and a table of the Pareto front of each."""

from . import figures as f
from .formats import EXACT, Fold, digits, pixels, table

CHARTS = {  # unit, column, whether lower is better
    "coherent rays": ("million rays per second", "coherent", False),
    "incoherent rays": ("million rays per second", "incoherent", False), "memory": ("MiB", "mib", True),
}  # fmt: skip
FINER = "errors_to_reference_level_p99_pixels"


def points(data, scene, column):
    """Returns the rows of a scene with columns `error` and `value`, and whether errors are against a finer mesh. They
    are if all rows of the scene, or of one job of it, have such errors. Otherwise levels cannot be compared, and the
    rows are of a single level."""
    frames = [data.views("full", scene, job) for job in [None, *sorted(set(data.here.job))]]
    frames = [frame[~frame.kind.isin(("NAIVE", "NAIVE-compact"))] for frame in frames]
    frame = next((frame for frame in frames if len(frame) and frame[FINER].notna().all()), None)
    to_reference = frame is not None
    if not to_reference:
        counts = frames[0].level.value_counts()
        frame = frames[0][frames[0].level == counts[counts == counts.max()].index.max()]
    frame = frame.assign(error=frame[FINER if to_reference else "errors_p99_pixels"], value=frame[column])
    return frame[frame.error.notna() & (frame.value > 0)], to_reference


def front_of(frame, low):
    """Returns the rows that no other row beats in both values, sorted by error. Errors below EXACT are equal. low:
    lower values are better."""
    ordered = frame.assign(error=frame.error.clip(lower=EXACT)).sort_values(["error", "value"], ascending=[True, low])
    best = ordered.value.cummin() if low else ordered.value.cummax()
    return frame.loc[ordered[best != best.shift()].index]


def draw(axes, frame, title, unit, low):
    frame = frame.sort_values("kind", key=lambda kinds: kinds.map(list(f.KINDS).index))
    # position of errors below EXACT
    left = min([error for error in frame.error if error >= EXACT] or [2 * EXACT]) / 2.5
    right, front = 1.6 * max(frame.error.max(), left), front_of(frame, low)
    xs, ys = [*front.error.where(front.error >= EXACT, left), right], [*front.value, front.value.iloc[-1]]
    axes.step(xs, ys, where="post", color=f.INK, linewidth=1, alpha=0.6, label="Pareto front")
    for kind, rows in frame.groupby("kind", sort=False):
        xs, sizes = rows.error.where(rows.error >= EXACT, left), (4 + 1.2 * (rows.level - 3).clip(lower=0)) ** 2
        color, mark = f.KINDS[kind]
        axes.scatter(xs, rows.value, sizes, color, marker=mark, edgecolors=f.INK, linewidths=0.3, label=kind, zorder=3)
    f.log_axis(axes, "x", left / 1.6, right)
    if low:
        f.log_axis(axes, "y", frame.value.min() / 1.5, frame.value.max() * 1.5)
    else:
        axes.set_ylim(0, 1.1 * frame.value.max())
    left_edge = " (left edge: none)" if frame.error.min() < EXACT else ""
    f.set_labels(axes, title, f"error, pixels, p99{left_edge}", unit, 4)


def section(data):
    """Charts of each scene with fronts of several rows, and all fronts."""
    parts, commands = [], []
    for scene in [scene for scene in data.scenes() if (data.full.scene == scene).sum() >= 4]:
        charts, fronts = [], []
        for name, (unit, column, low) in CHARTS.items():
            frame, to_reference = points(data, scene, column)
            if len(frame) > 1:
                level = frame.run_settings_reference_level.iloc[0] if to_reference else frame.level.iloc[0]
                against = f"GRID at level {level:.0f}" if to_reference else f"GRID of the same level, {level:.0f}"
                front, title = front_of(frame, low), f"{scene}, {name}: error against\n{against}"
                columns = [("", "representation", str), ("level", "level", str), ("p99, pixels", "error", pixels)]
                text = f"{scene}, {name}, error against {against}: {len(front)} of {len(frame)} on the front"
                fronts.append(table(front, [*columns, (unit, "value", digits)], 1, text))
                arguments = (f"{name} against error, {scene}", 3.9, draw, frame, title, unit, low)
                charts += [f.chart(*arguments)] if len(front) > 1 else []
                commands += list(frame.command)
        parts += [charts, Fold(f"{scene}: fronts as tables", fronts)] if fronts else []
    return parts, commands
