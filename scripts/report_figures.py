# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Charts of the report as SVG, each once for light and once for dark pages. Charts are
small: side by side on a desk, one below the other on a phone."""

import io
import math

import matplotlib

matplotlib.use("svg")
import matplotlib.image  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.ticker import FuncFormatter, NullFormatter  # noqa: E402

# Okabe and Ito's, told apart by colour-blind readers as well.
KIND_COLOURS = {
    "NAIVE": "#999999",
    "GRID": "#56B4E9",
    "cGRID": "#0072B2",
    "cVOXEL": "#D55E00",
    "cLEAF": "#009E73",
    "cVERT": "#CC79A7",
}
KIND_MARKS = {"NAIVE": "P", "GRID": "X", "cGRID": "s", "cVOXEL": "^", "cLEAF": "o", "cVERT": "D"}
LEVEL_COLOURS = {4: "#4daf4a", 5: "#4682c8", 6: "#d9534f", 7: "#9467bd", 8: "#8c6d31"}  # the paper's for 4 to 6
THEMES = {"light": {"ink": "#1c2733", "grid": "#d9dee4"}, "dark": {"ink": "#dfe6ee", "grid": "#3a444f"}}
EXACT = 1e-3  # pixels: smaller errors are rounding, and are drawn at the left edge


def themed(draw, width=4.6, height=3.5):
    """Calls draw(axes, theme) for each theme. Returns {theme: SVG text}."""
    pictures = {}
    for name, theme in THEMES.items():
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
            figure, axes = plt.subplots(figsize=(width, height), layout="constrained")
            figure.get_layout_engine().set(w_pad=0.08, h_pad=0.06)
            draw(axes, theme)
            out = io.BytesIO()
            figure.savefig(out, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
            plt.close(figure)
        pictures[name] = out.getvalue()
    return pictures


def sort_key(label):
    order = ["NAIVE", "GRID", "cGRID", "cVOXEL", "cLEAF", "cVERT"]
    kind, _, frame = label.partition("^")
    return (order.index(kind) if kind in order else 99, frame)


def math_label(label):
    kind, _, frame = label.partition("^")
    return f"{kind}$^{{{frame}}}$" if frame.isdigit() else label.replace("^", " ")


def plain_number(value, _=None):
    if value >= 1e6:
        return f"{value / 1e6:g}M"
    if value >= 1e3:
        return f"{value / 1e3:g}k"
    return f"{value:g}"


def log_axis(axis):
    axis.set_major_formatter(FuncFormatter(plain_number))
    axis.set_minor_formatter(NullFormatter())


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
        axes.set_xticks(
            range(len(labels)), [math_label(label) for label in labels], rotation=40, ha="right", rotation_mode="anchor"
        )
        axes.grid(axis="x", visible=False)
        axes.set_ylabel(unit)
        axes.set_title(title)
        axes.legend(
            ncols=len(levels), loc="upper center", bbox_to_anchor=(0.5, -0.26), columnspacing=1.0, handlelength=1.2
        )

    return themed(draw)


def memory_bars(level, rows, grid_bytes):
    """Figure 17: inner nodes dark, leaves light, on a log scale, parts of GRID above."""

    def draw(axes, theme):
        tops = [row.bytes / 2**20 for row in rows]
        for i, row in enumerate(rows):
            colour = LEVEL_COLOURS.get(level, "#777777")
            inner = row.memory["inner_bytes"] / 2**20
            axes.bar(i, tops[i], 0.75, color=colour, alpha=0.45, label="leaves" if i == 0 else None)
            axes.bar(i, inner, 0.75, color=colour, label="inner nodes" if i == 0 else None)
            if grid_bytes:
                axes.text(
                    i,
                    tops[i] * 1.08,
                    f"{100 * row.bytes / grid_bytes:.0f}%",
                    ha="center",
                    va="bottom",
                    fontsize=8.5,
                    color=theme["ink"],
                )
        axes.set_yscale("log")
        log_axis(axes.yaxis)
        lowest = min(max(row.memory["inner_bytes"] / 2**20, 1e-3) for row in rows)
        axes.set_ylim(0.5 * lowest, 2.0 * max(tops))
        axes.set_xticks(
            range(len(rows)), [math_label(row.label) for row in rows], rotation=40, ha="right", rotation_mode="anchor"
        )
        axes.grid(axis="x", visible=False)
        axes.set_ylabel("MiB")
        axes.set_title(f"Level {level}")
        axes.legend(ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.26))

    return themed(draw)


def pareto(points, lower_is_better):
    """The points (error, value) that no other beats in both, by error."""
    front, best = [], None
    for error, value in sorted(points, key=lambda p: (p[0], p[1] if lower_is_better else -p[1])):
        if best is None or (value < best if lower_is_better else value > best):
            front.append((error, value))
            best = value
    return front


def scatter(title, unit, points, lower_is_better):
    """points: (row, error in pixels, value). The larger a mark, the higher its level; those on the front are labelled
    with level and frame level."""

    def draw(axes, theme):
        edge = min([error for _, error, _ in points if error >= EXACT] or [2 * EXACT]) / 2.5
        placed = [(row, error if error >= EXACT else edge, value) for row, error, value in points]
        front = pareto([(error, value) for _, error, value in placed], lower_is_better)
        right = 1.6 * max(error for _, error, _ in placed)
        axes.plot(
            [p[0] for p in front] + [right],
            [p[1] for p in front] + [front[-1][1]],
            "-",
            color=theme["ink"],
            linewidth=1,
            alpha=0.6,
            label="Pareto front",
            drawstyle="steps-post",
        )
        seen = set()
        for row, error, value in sorted(placed, key=lambda point: kind_order(point[0].kind)):
            axes.plot(
                error,
                value,
                KIND_MARKS.get(row.kind, "o"),
                color=KIND_COLOURS.get(row.kind, "#777777"),
                markersize=3.2 + 1.0 * max(0, row.level - 3),
                markeredgecolor=theme["ink"],
                markeredgewidth=0.3,
                label=None if row.kind in seen else row.kind,
            )
            seen.add(row.kind)
            if (error, value) in front:
                text = f"{row.level}" if row.frame_level is None else f"{row.level}$^{{{row.frame_level}}}$"
                axes.annotate(
                    text,
                    (error, value),
                    fontsize=8,
                    xytext=(4, -9 if lower_is_better else 5),
                    textcoords="offset points",
                    color=theme["ink"],
                )
        axes.set_xscale("log")
        axes.set_xlim(edge / 1.6, right)
        log_axis(axes.xaxis)
        if lower_is_better:
            axes.set_yscale("log")
            log_axis(axes.yaxis)
        else:
            axes.set_ylim(bottom=0)
        exact = any(error < EXACT for _, error, _ in points)
        axes.set_xlabel("RMSE within 5 pixels" + (" (left edge: none)" if exact else ""))
        axes.set_ylabel(unit)
        axes.set_title(title)
        axes.legend(ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.2), columnspacing=1.0, markerscale=0.8)

    return themed(draw, height=3.9)


def kind_order(kind):
    return list(KIND_COLOURS).index(kind) if kind in KIND_COLOURS else 99


def growth(title, unit, lines, log_value=True):
    """lines: {(kind label, scene): [(quads, value)]}."""

    def draw(axes, theme):
        scenes = sorted({scene for _, scene in lines})
        styles = ["-", "--", ":", "-."]
        for (label, scene), points in sorted(lines.items(), key=lambda item: (item[0][1], sort_key(item[0][0]))):
            kind = label.partition("^")[0]
            first = scene == scenes[0] or not any((label, s) in lines for s in scenes[: scenes.index(scene)])
            axes.plot(
                [p[0] for p in points],
                [p[1] for p in points],
                styles[scenes.index(scene) % 4],
                marker=KIND_MARKS.get(kind, "o"),
                color=KIND_COLOURS.get(kind, "#777777"),
                markersize=4.5,
                label=math_label(label) if first else None,
                linewidth=1.2,
            )
        axes.set_xscale("log")
        log_axis(axes.xaxis)
        if log_value:
            axes.set_yscale("log")
            log_axis(axes.yaxis)
        else:
            axes.set_ylim(bottom=0)
        axes.set_xlabel(
            "quads ("
            + ", ".join(f"{name}: {['solid', 'dashed', 'dotted', 'dash-dot'][i % 4]}" for i, name in enumerate(scenes))
            + ")"
        )
        axes.set_ylabel(unit)
        axes.set_title(title)
        axes.legend(ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.2), columnspacing=1.0)

    return themed(draw, height=3.9)


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
