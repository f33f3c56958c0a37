# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on growth: memory, build and speed over the number of quads."""

import report_figures as f
import report_page as p
from report_tradeoffs import speed_value

NAMES = ("NAIVE", "GRID", "cGRID^2", "cVOXEL^2", "cLEAF^2", "cLEAF-only^2", "cVERT")
STYLES = (("-", "solid"), ("--", "dashed"), (":", "dotted"), ("-.", "dash-dot"))

CHARTS = (
    ("Memory", "MiB", lambda row: row.bytes / 2**20, True),
    ("Build", "seconds, all threads", lambda row: row.build_seconds, True),
    ("Speed, incoherent", "millions a second, one thread", lambda row: speed_value("incoherent")(row, "full"), False),
)


def chart(title, unit, lines, log_value):
    """lines: {(representation, scene): [(quads, value)]}."""

    def draw(axes, _):
        scenes = sorted({scene for _, scene in lines})
        named = set()
        for (label, scene), points in sorted(lines.items(), key=lambda item: (item[0][1], f.sort_key(item[0][0]))):
            kind = label.partition("^")[0]
            axes.plot(
                [p[0] for p in points],
                [p[1] for p in points],
                STYLES[scenes.index(scene) % len(STYLES)][0],
                marker=f.KIND_MARKS.get(kind, "o"),
                color=f.KIND_COLOURS.get(kind, "#777777"),
                markersize=4.5,
                label=None if label in named else f.math_label(label),
                linewidth=1.2,
            )
            named.add(label)
        axes.set_xscale("log")
        f.log_axis(axes.xaxis)
        if log_value:
            axes.set_yscale("log")
            f.log_axis(axes.yaxis)
        else:
            axes.set_ylim(bottom=0)
        styles = ", ".join(f"{name}: {STYLES[i % len(STYLES)][1]}" for i, name in enumerate(scenes))
        axes.set_xlabel(f"quads ({styles})")
        axes.set_ylabel(unit)
        axes.set_title(title)
        f.legend(axes, 3)

    return f.themed(draw, height=3.9)


def section(data):
    charts, used = [], []
    for title, unit, value, log_value in CHARTS:
        lines = {}
        for scene in data.scenes():
            for name in NAMES:
                rows = [data.pick(scene, level, name) for level in data.levels(scene)]
                rows = [row for row in rows if row and value(row)]
                if len(rows) > 1:
                    lines[(name, scene)] = [(row.quads, value(row)) for row in rows]
                    used += rows
        if lines:
            charts.append(p.chart(chart(title, unit, lines, log_value), f"{title} over the number of quads"))
    body = p.charts(charts) if charts else p.missing("one scene at several levels")
    return p.section("growth", "Growth over the number of quads", body, commands=[row.command for row in used])
