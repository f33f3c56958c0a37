# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Draws groups of horizontal bars as SVG."""

from xml.sax.saxutils import escape

WIDTH, BAR, GAP, LEFT, RIGHT = 900, 15, 14, 130, 230
COLORS = ("#9aa4ae", "#6b7783", "#c8501e", "#e39a6f")
FONT = "font-family='Helvetica, Arial, sans-serif'"


def text(x, y, words, size=12, attributes=""):
    return f"<text x='{x:.0f}' y='{y:.0f}' font-size='{size}' {attributes}>\n{escape(words)}\n</text>"


def svg(title, groups, source):
    """Returns the picture.

    groups: [(caption, [(name of the bar, length, label after the bar), ...]), ...]; all bars have the same scale.
    """
    scale = (WIDTH - LEFT - RIGHT) / max(length for _, bars in groups for _, length, _ in bars)
    out, y = [text(8, 22, title, 14, "font-weight='bold'")], 34
    for caption, bars in groups:
        y += GAP + 12
        out.append(text(8, y, caption, 13, "font-weight='bold'"))
        y += 6
        for (name, length, label), color in zip(bars, COLORS, strict=True):
            width = max(length * scale, 1)
            out.append(text(LEFT - 6, y + 11, name, 11, "text-anchor='end'"))
            out.append(f"<rect x='{LEFT}' y='{y}' width='{width:.1f}' height='{BAR - 2}' fill='{color}'/>")
            out.append(text(LEFT + width + 6, y + 11, f"{length:.1f}: {label}", 11))
            y += BAR
    y += GAP + 10
    out.append(text(8, y, source, 10, "fill='#555555'"))
    size = f"width='{WIDTH}' height='{y + 10}' viewBox='0 0 {WIDTH} {y + 10}'"
    background = f"<rect width='{WIDTH}' height='{y + 10}' fill='white'/>"
    return "\n".join([f"<svg xmlns='http://www.w3.org/2000/svg' {FONT}\n  {size}>", background, *out, "</svg>", ""])
