# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""What the charts of the report have in common: SVG, each once for light and once for dark pages, colours, axes and
numbers. Charts are small: side by side on a desk, one below the other on a phone."""

import io
import math

try:
    import matplotlib
except ModuleNotFoundError as error:
    raise SystemExit("matplotlib is not installed for this Python: install the package python3-matplotlib") from error

matplotlib.use("svg")
import matplotlib.image  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.ticker import FuncFormatter, Locator, NullLocator  # noqa: E402

from report_data import KINDS  # noqa: E402

# Okabe and Ito's, told apart by colour-blind readers as well.
KIND_COLOURS = {
    "NAIVE": "#999999",
    "GRID": "#56B4E9",
    "cGRID": "#0072B2",
    "cVOXEL": "#D55E00",
    "cLEAF": "#E69F00",
    "cLEAF-only": "#009E73",
    "cVERT": "#CC79A7",
}
KIND_MARKS = {"NAIVE": "P", "GRID": "X", "cGRID": "s", "cVOXEL": "^", "cLEAF": "v", "cLEAF-only": "o", "cVERT": "D"}
LEVEL_COLOURS = {4: "#4daf4a", 5: "#4682c8", 6: "#d9534f", 7: "#9467bd", 8: "#8c6d31"}  # the paper's for 4 to 6
THEMES = {"light": {"ink": "#1c2733", "grid": "#d9dee4"}, "dark": {"ink": "#dfe6ee", "grid": "#3a444f"}}
EXACT = 1e-3  # pixels: smaller errors are rounding, and are drawn at the left edge


def themed(draw, width=4.6, height=3.5, rows=1, columns=1):
    """Calls draw(axes, theme), with an array of axes where rows or columns are given. Returns {theme: SVG}: the dark
    picture is the light one with other ink, as all else is drawn in colours that suit both."""
    theme = THEMES["light"]
    style = {
        "font.size": 10,
        "text.color": theme["ink"],
        "axes.labelcolor": theme["ink"],
        "axes.edgecolor": theme["grid"],
        "xtick.color": theme["ink"],
        "ytick.color": theme["ink"],
        "grid.color": theme["grid"],
        "axes.grid": True,
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "legend.frameon": False,
        "legend.fontsize": 8.5,
        "axes.titlesize": 11,
        "svg.hashsalt": "cbvh",
        "font.family": "DejaVu Sans",
    }
    with plt.rc_context(style):
        figure, axes = plt.subplots(rows, columns, figsize=(width, height), layout="constrained")
        figure.get_layout_engine().set(w_pad=0.08, h_pad=0.06)
        draw(axes, theme)
        out = io.BytesIO()
        figure.savefig(out, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
        plt.close(figure)
    pictures = {"light": out.getvalue(), "dark": out.getvalue()}
    for name, colour in THEMES["dark"].items():
        pictures["dark"] = pictures["dark"].replace(theme[name].encode(), colour.encode())
    return pictures


def sort_key(label):
    kind, _, frame = label.partition("^")
    return (KINDS.index(kind) if kind in KINDS else 99, frame)


def math_label(label):
    kind, _, frame = label.partition("^")
    return f"{kind}$^{{{frame}}}$" if frame.isdigit() else label.replace("^", " ")


def kind_order(kind):
    return list(KIND_COLOURS).index(kind) if kind in KIND_COLOURS else 99


def plain_number(value, _=None):
    if value >= 1e6:
        return f"{value / 1e6:g}M"
    if value >= 1e3:
        return f"{value / 1e3:g}k"
    return f"{value:g}"


class LogLabels(Locator):
    """Round values on a logarithmic axis: at least three, and no more than there is room for."""

    STEPS = ((1,), (1, 3), (1, 2, 5), (1, 1.5, 2, 3, 5, 7), (1, 1.2, 1.5, 1.7, 2, 2.5, 3, 3.5, 4, 5, 6, 7, 8, 9))

    def __call__(self):
        return self.tick_values(*self.axis.get_view_interval())

    def tick_values(self, vmin, vmax):
        low, high = min(vmin, vmax), max(vmin, vmax)
        decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        for steps in self.STEPS:
            ticks = [step * 10.0**decade for decade in decades for step in steps]
            ticks = [tick for tick in ticks if low * (1 - 1e-9) <= tick <= high * (1 + 1e-9)]
            if len(ticks) >= 3:
                break
        return ticks[:: max(1, math.ceil(len(ticks) / 7))]


def log_axis(axis):
    axis.set_major_locator(LogLabels())
    axis.set_major_formatter(FuncFormatter(plain_number))
    axis.set_minor_locator(NullLocator())


def legend(axes, columns):
    """In a strip below everything else, so that it covers nothing."""
    handles, names = axes.get_legend_handles_labels()
    if handles:
        strip = (15 * math.ceil(len(handles) / columns) + 4) / (72 * axes.figure.get_figheight())
        axes.figure.get_layout_engine().set(rect=(0, strip, 1, 1 - strip))
        axes.figure.legend(handles, names, ncols=columns, loc="lower center", columnspacing=1.0, handlelength=1.4)


def names_below(axes, labels):
    axes.set_xticks(
        range(len(labels)), [math_label(label) for label in labels], rotation=40, ha="right", rotation_mode="anchor"
    )
    axes.grid(axis="x", visible=False)


def names_beside(axes, labels):
    """Of horizontal bars, the first at the top."""
    axes.set_yticks(range(len(labels)), [math_label(label) for label in labels])
    axes.set_ylim(len(labels) - 0.4, -0.6)
    axes.grid(axis="y", visible=False)


def bars_by_level(title, unit, labels, levels, value):
    """Grouped bars. value(label, level): (middle, low, high) or None."""

    def draw(axes, theme):
        width = 0.8 / max(1, len(levels))
        for k, level in enumerate(levels):
            xs, ys, lows, highs = [], [], [], []
            for i, label in enumerate(labels):
                found = value(label, level)
                if found:
                    xs.append(i + (k - 0.5 * (len(levels) - 1)) * width)
                    ys.append(found[0])
                    lows.append(max(0.0, found[0] - found[1]))
                    highs.append(max(0.0, found[2] - found[0]))
            axes.bar(
                xs,
                ys,
                0.92 * width,
                color=LEVEL_COLOURS.get(level, "#777777"),
                label=f"level {level}",
                yerr=[lows, highs],
                error_kw={"ecolor": theme["ink"], "elinewidth": 0.8, "capsize": 1.5},
            )
        names_below(axes, labels)
        axes.set_ylabel(unit)
        axes.set_title(title)
        legend(axes, len(levels))

    return themed(draw)


def picture(path, quality):
    """A PNG as WebP, which is a quarter of its size."""
    pixels = matplotlib.image.imread(path)
    out = io.BytesIO()
    matplotlib.image.imsave(out, pixels, format="webp", pil_kwargs={"quality": quality, "method": 4})
    return out.getvalue()


def mebibytes(count):
    """Three digits at least."""
    value = count / 2**20
    return f"{value:.{0 if value >= 100 else 1 if value >= 10 else 2 if value >= 1 else 3}f} MiB"


def error_text(value):
    if value == 0 or not math.isfinite(value):
        return "0"
    return f"{value:.3f}" if value < 10 else f"{value:.1f}"


def signed(value):
    """With four digits and its sign, which rounding to nothing does not leave behind."""
    text = f"{value:+.4f}"
    return text if float(text) else "0.0000"
