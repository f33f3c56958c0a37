# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Figure 17: memory, as bars from zero whose parts add up to all that the device holds after the commit."""

from html import escape

import report_figures as f
import report_page as p

LEVELS = (4, 5, 6)
COLOURS = {"leaves": "#9ec9e2", "nodes of blocks": "#0072B2", "frames": "#E69F00", "tree above": "#5b6875"}
TEXT = (
    "<p>What the device holds after the commit, everything included, and its parts: <i>leaves</i> are vertices, heights "
    "or lattice coordinates; <i>nodes of blocks</i> and <i>frames</i> are the compressed tree below a block; <i>tree "
    "above</i> is Embree's own tree over the blocks, or over everything in NAIVE and GRID, and all else. Leaves of NAIVE "
    "and GRID are computed from their layout, the others are counted. Percentages are of GRID. The second chart of a "
    "level leaves out what is larger than a quarter of GRID, so that the parts of the rest are seen.</p>"
)


def parts(row):
    """Bytes of each part. They add up to row.bytes."""
    compression = row.memory.get("compression", {})
    found = {
        "leaves": row.memory["leaf_bytes"],
        "nodes of blocks": compression.get("node_bytes", 0),
        "frames": compression.get("frame_bytes", 0),
    }
    return {**found, "tree above": row.bytes - sum(found.values())}


def stack(axes, rows, value, text, theme):
    """Horizontal bars of rows, the first at the top. value: of bytes of a row; text: at the end of its bar."""
    widest = max(value(row, row.bytes) for row in rows)
    for i, row in enumerate(rows):
        begin = 0.0
        for name, count in parts(row).items():
            length = value(row, count)
            axes.barh(i, length, 0.7, left=begin, color=COLOURS[name], label=name if i == 0 else None)
            begin += length
        axes.text(begin + 0.01 * widest, i, text(row), va="center", fontsize=8.5, color=theme["ink"])
    f.names_beside(axes, [row.label for row in rows])
    axes.set_xlim(0, 1.3 * widest)


def chart(title, rows, grid_bytes):
    def draw(axes, theme):
        def text(row):
            share = f", {100 * row.bytes / grid_bytes:.1f}%" if grid_bytes else ""
            return f.mebibytes(row.bytes).removesuffix(" MiB") + share

        stack(axes, rows, lambda row, count: count / 2**20, text, theme)
        axes.set_xlabel("MiB")
        axes.set_title(title)
        f.legend(axes, 4)

    return f.themed(draw, height=1.6 + 0.24 * len(rows))


def section(data, names):
    """names: of the representations that are shown."""
    main, body, rows = data.main_scene(), "", []
    for level in LEVELS:
        here = [row for row in (data.pick(main, level, name) for name in names) if row]
        grid = data.pick(main, level, "GRID")
        small = [row for row in here if grid and 4 * row.bytes <= grid.bytes]
        charts = []
        for shown, title in ((here, f"Level {level}"), (small, f"Level {level}, up to a quarter of GRID")):
            if shown:
                charts.append(p.chart(chart(title, shown, grid.bytes if grid else 0), f"Memory, {title}"))
        body += p.charts(charts) if charts else ""
        rows += here
    skipped = "".join(f'<p class="missing">{escape(text)}</p>' for text in data.skipped)
    return p.section(
        "figure17",
        f"Figure 17: memory, {main}",
        TEXT,
        body or p.missing(f"memory of {main} at levels 4 to 6"),
        skipped,
        commands=[row.command for row in rows],
    )
