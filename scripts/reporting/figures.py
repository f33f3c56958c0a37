# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Helpers for the charts of the report: SVG, colors, axes and legends."""

import base64
import io
import math
from dataclasses import dataclass

import matplotlib

matplotlib.use("svg")
import matplotlib.image  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator  # noqa: E402

# Marks, and the colors of Okabe and Ito, which are distinguishable for color-blind readers.
KINDS = {
    "NAIVE": ("#999999", "P"), "NAIVE-compact": ("#000000", "p"), "GRID": ("#56B4E9", "X"), "cGRID": ("#0072B2", "s"),
    "cVOXEL": ("#D55E00", "^"), "cLEAF": ("#E69F00", "v"), "cLEAF-only": ("#009E73", "o"), "cVERT": ("#CC79A7", "D"),
}  # fmt: skip
BLUE, ORANGE, INK, LINES = "#0072B2", "#E69F00", "#1c2733", "#d9dee4"
STYLE = {
    "font.size": 10, "font.family": "DejaVu Sans", "axes.titlesize": 11, "legend.fontsize": 8.5, "grid.color": LINES,
    "text.color": INK, "axes.labelcolor": INK, "xtick.color": INK, "ytick.color": INK, "axes.edgecolor": LINES,
    "axes.grid": True, "axes.axisbelow": True, "axes.spines.top": False, "axes.spines.right": False,
    "legend.frameon": False, "svg.hashsalt": "cbvh",
}  # fmt: skip


@dataclass
class Picture:
    """text: the alternative text. kind: the MIME subtype of the image."""

    text: str
    kind: str
    content: bytes
    caption: str = ""

    @property
    def url(self):
        return f"data:image/{self.kind};base64,{base64.b64encode(self.content).decode()}"


def chart(text, height, draw, *arguments):
    """Returns a chart as a Picture. draw(axes, *arguments) draws it. height: in inches."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(4.6, height), layout="constrained")
        figure.get_layout_engine().set(w_pad=0.08, h_pad=0.06)
        draw(axes, *arguments)
        out = io.BytesIO()
        figure.savefig(out, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
        plt.close(figure)
    return Picture(text, "svg+xml", out.getvalue())


def webp_picture(path, text, caption):
    """Returns a PNG as a Picture in WebP, which is a quarter of its size."""
    out, pil = io.BytesIO(), {"quality": 87, "method": 4}
    matplotlib.image.imsave(out, matplotlib.image.imread(path), format="webp", pil_kwargs=pil)
    return Picture(text, "webp", out.getvalue(), caption)


def math_label(label):
    """Returns the name of a representation with the frame level as a superscript."""
    kind, _, frame = label.partition("^")
    return f"{kind}$^{{{frame}}}$" if frame.isdigit() else label.replace("^", " ")


def plain_number(value, _=None):
    size, letter = (1e6, "M") if value >= 1e6 else (1e3, "k") if value >= 1e3 else (1, "")
    return f"{value / size:g}{letter}"


def log_ticks(low, high):
    """Returns three to seven round values from low to high."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    choices = [[step * 10.0**decade for decade in decades for step in steps] for steps in ((1,), (1, 3), (1, 2, 5))]
    for ticks in [*choices, MaxNLocator(6).tick_values(low, high)]:
        ticks = [tick for tick in ticks if low * (1 - 1e-9) <= tick <= high * (1 + 1e-9)]
        if len(ticks) >= 3:
            break
    return ticks[:: math.ceil(len(ticks) / 7)]


def log_axis(axes, axis_name, low=None, high=None):
    """Makes the axis x or y logarithmic. The default range is that of the drawn data."""
    axis = getattr(axes, f"{axis_name}axis")
    axes.set(**{f"{axis_name}scale": "log"})
    if low is not None:
        axes.set(**{f"{axis_name}lim": (low, high)})
    axis.set_major_locator(FixedLocator(log_ticks(*axis.get_view_interval())))
    axis.set_major_formatter(FuncFormatter(plain_number))
    axis.set_minor_locator(NullLocator())


def set_labels(axes, title, x="", y="", columns=3):
    """Sets title and axis labels. The legend is in a strip below the chart, so that it covers nothing."""
    axes.set(title=title, xlabel=x, ylabel=y)
    handles, texts = axes.get_legend_handles_labels()
    strip = (15 * math.ceil(len(handles) / columns) + 4) / (72 * axes.figure.get_figheight()) if handles else 0
    axes.figure.get_layout_engine().set(rect=(0, strip, 1, 1 - strip))
    axes.figure.legend(handles, texts, ncols=columns, loc="lower center", columnspacing=1.0, handlelength=1.4)


def row_labels(axes, labels):
    """Labels of horizontal bars, from top to bottom."""
    axes.set_yticks(range(len(labels)), [math_label(label) for label in labels])
    axes.set_ylim(len(labels) - 0.4, -0.6)
    axes.grid(axis="y", visible=False)
