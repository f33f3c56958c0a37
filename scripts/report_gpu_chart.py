# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The chart of the section on GPUs: speed against memory, a line a representation, a mark a level."""

import report_figures as f
import report_labels as labels_of_marks

def speed_against_memory(title, lines):
    """lines: {label: [(bytes a quad on the device, millions of rays a second, level)]}."""
    labels = sorted(lines, key=f.sort_key)

    def draw(axes, theme):
        seen = set()
        for label in labels:
            kind = label.partition("^")[0]
            colour, points = f.KIND_COLOURS.get(kind, "#777777"), sorted(lines[label], key=lambda point: point[2])
            hollow = {"markerfacecolor": "none"} if kind in seen else {}
            axes.plot([p[0] for p in points], [p[1] for p in points], "-", color=colour, linewidth=1, alpha=0.5)
            for x, y, level in points:
                axes.plot(x, y, f.KIND_MARKS.get(kind, "o"), color=colour, markersize=labels_of_marks.mark_size(level), **hollow)
            axes.plot([], [], f.KIND_MARKS.get(kind, "o"), color=colour, markersize=6, label=f.math_label(label), **hollow)
            seen.add(kind)
        marks = [mark for label in labels for mark in lines[label]]
        axes.set_xscale("log")
        axes.set_xlim(min(m[0] for m in marks) / 1.5, max(m[0] for m in marks) * 1.5)
        f.log_axis(axes.xaxis)
        axes.set_ylim(0, 1.12 * max(m[1] for m in marks))
        axes.set_xlabel("bytes a quad, on the device and imported")
        axes.set_ylabel("million rays a second")
        axes.set_title(title)
        f.legend(axes, 4)
        labels_of_marks.write_labels(axes, [(x, y, level, str(level)) for x, y, level in marks], theme["ink"])

    return f.themed(draw, height=3.9)
