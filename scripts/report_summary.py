# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The first screen of the report: what compression saves and costs, in a sentence each for memory, speed and error of the main
scene, and beside it from where to where that goes over all scenes, and where it is worst."""

from dataclasses import dataclass
from html import escape

import report_figures as f
import report_page as p
import report_summary_chart as picture
from report_data import Row

FIRST = ("cVERT", "cLEAF^2", "cLEAF-only^2", "cLEAF-only^3", "cVOXEL^3", "cVOXEL^2", "cGRID^2")  # the first that was measured is spoken of
SHOWN = ("GRID", "cGRID^2", "cVOXEL^2", "cVOXEL^3", "cLEAF^2", "cLEAF-only^2", "cLEAF-only^3", "cVERT")


@dataclass
class Headline:
    """A representation beside GRID: the same scene, level and instruction set."""

    row: Row
    grid: Row

    @property
    def smaller(self):
        return self.grid.bytes / self.row.bytes

    def times_grid(self, ray_set):
        speed = self.row.speed("full", ray_set)
        return speed["relative_to_grid"]["median"] if speed else None


def headline(data, level=None, scene=None, labels=FIRST):
    """Of the main scene or another, at level 6 or the finest below it, or else the finest. None where nothing was compressed."""
    scene = scene or data.main_scene()
    levels = [level] if level is not None else sorted(data.levels(scene), key=lambda level: (level > 6, -level))
    for level in levels:
        grid = data.pick(scene, level, "GRID")
        for label in labels if grid else ():
            row = data.pick(scene, level, label)
            if row:
                return Headline(row, grid)
    return None


def of_all_scenes(data, found):
    """The same representation of each scene."""
    return list(filter(None, (headline(data, scene=scene, labels=(found.row.label,)) for scene in data.scenes())))


def over_scenes(values, text, kind, worst):
    """A sentence: from where to where, and the worst, named. values: (scene, value, where); empty for one scene alone. text: of
    a value; kind: in words, with {} for the range; worst: min or max, of values, and what it is called."""
    scenes = {scene for scene, *_ in values}
    if len(scenes) < 2:
        return ""
    low, high = min(value for _, value, _ in values), max(value for _, value, _ in values)
    choose, called = worst
    scene, _, where = choose(values, key=lambda found: found[1])
    reach = text(low) if text(low) == text(high) else f"{text(low)} to {text(high)}"
    return f"Over {len(scenes)} scenes {kind.format(reach)}, {called} for {scene}{where}."


def memory_over_scenes(data, found):
    values = [(o.row.scene, o.smaller, f" at level {o.row.level}") for o in of_all_scenes(data, found)]
    return over_scenes(values, times, "it is {} times smaller", (min, "least"))


def place(row, view, *more):
    words = [] if view == "full" else [f"{view} view"]
    return "".join(", " + word for word in [*words, *more])


def speed_over_scenes(data, found):
    values = [
        (o.row.scene, speed["relative_to_grid"]["median"], place(o.row, view, f"{ray_set} rays"))
        for o in of_all_scenes(data, found)
        for view in o.row.views
        for ray_set in ("coherent", "incoherent")
        for speed in [o.row.speed(view, ray_set)]
        if speed
    ]
    return over_scenes(values, times, "and their views it is {} times GRID's speed", (min, "least"))


def error_over_scenes(data, found):
    values = [
        (o.row.scene, o.row.errors(view)["p99_pixels"], place(o.row, view))
        for o in of_all_scenes(data, found)
        for view in o.row.views
        if o.row.errors(view)
    ]
    return over_scenes(values, two_digits, "and their views it is {} pixels", (max, "most"))


def times(value):
    return f"{value:.1f}" if value >= 1.95 else f"{value:.2f}"


def two_digits(value):
    """Of an error in pixels."""
    return f"less than {f.EXACT:g}" if value < f.EXACT / 10 else f"{value:#.2g}".removesuffix(".")


def smaller_in_words(found):
    return f"{times(found.smaller)} times smaller" if found.smaller >= 1 else f"{times(1 / found.smaller)} times larger"


def memory(found):
    """The figure, and the sentence."""
    row, grid = found.row, found.grid
    return smaller_in_words(found), (
        f"{row.label} keeps {row.scene} at level {row.level}, {row.quads / 1e6:.3g} million quads, in "
        f"{f.mebibytes(row.bytes)} or {row.memory['bytes_per_quad']:.2f} bytes a quad, and Embree's own GRID takes "
        f"{f.mebibytes(grid.bytes)} or {grid.memory['bytes_per_quad']:.2f}."
    )


def speed(found):
    """None where no speed was measured."""
    known = []
    for name in ("coherent", "incoherent"):
        speeds = [row.speed("full", name) for row in (found.row, found.grid)]
        if all(speeds):
            known.append((name, found.times_grid(name), *(s["mrays_per_second"]["median"] for s in speeds)))
    if not known:
        return None
    figure = " and ".join(dict.fromkeys(times(ratio) for _, ratio, _, _ in known)) + " times GRID's speed"
    rays = " and ".join(f"{mrays:.3g} million {name} rays" for name, _, mrays, _ in known)
    of_grid = " and ".join(f"{mrays:.3g}" for *_, mrays in known)
    return figure, f"One thread traces {rays} a second in {found.row.label}, and {of_grid} million in GRID."


def error(found):
    """None where no error was measured in the full view."""
    errors = found.row.errors("full")
    if not errors:
        return None
    figure = f"{two_digits(errors['p99_pixels'])} pixels of error"
    beyond = f"{errors['beyond_5_pixels'] or 'none'} of {errors['rays']:,} rays"
    text = (
        f"99 of 100 hits of {found.row.label} are nearer than that to GRID's (p99), half of them nearer than "
        f"{two_digits(errors['median_pixels']).removeprefix('less than ')} (median), and {beyond} hit more than 5 pixels away"
    )
    ours, theirs = (row.views.get("full", {}).get("errors_to_true_surface") for row in (found.row, found.grid))
    if ours and theirs:
        both = [two_digits(errors["p99_pixels"]) for errors in (ours, theirs)]
        text += f"; from the true surface p99 is {both[0]}, and GRID's own is {both[1]}"
    return figure, text + "."


def statements(data, found):
    """Of each the figure, the sentence, and the range over all scenes, empty where there is one."""
    return {
        "memory": (*memory(found), memory_over_scenes(data, found)),
        "speed": (*(speed(found) or ("No speed", "Speeds were not measured in the full view.")), speed_over_scenes(data, found)),
        "error": (*(error(found) or ("No error", "Errors were not measured in the full view.")), error_over_scenes(data, found)),
    }


def other_levels(data, found):
    """How many times smaller at the others, from the finest; empty without others."""
    others = [headline(data, level) for level in reversed(data.levels(found.row.scene)) if level != found.row.level]
    others = [o for o in others if o and o.row.label == found.row.label]
    return ", ".join(f"{times(o.smaller)} at level {o.row.level}" for o in others)


def caption(data, found, rows):
    more = other_levels(data, found)
    exact = [f" Of {p.label(row.label)} {100 * row.exact_share:.0f}% of the quads are stored exactly, as cVERT." for row in rows if row.exact_share]
    return (
        f"<b>{escape(found.row.scene)}, level {found.row.level}</b>, full view, single rays, one thread of "
        f"{escape(found.row.run['cpu'])} ({escape(data.isa)}). {p.label(found.row.label)} is "
        f"{smaller_in_words(found)} than GRID{', ' + more if more else ''}. Errors are against GRID's hits: 99 of 100 stay below p99, half of them below the median; “none” is less "
        f"than {f.EXACT:g} pixels.{''.join(exact)}"
    )


def first_screen(data):
    """HTML: three sentences and a picture."""
    found = headline(data)
    if not found:
        on_gpu = '<p>What was measured on a GPU is in <a href="#gpu">its section</a>.</p>' if data.gpu else ""
        return p.missing("a compressed representation beside GRID, on a processor") + on_gpu
    cells = "".join(
        f'<p><b class="figure">{escape(figure)}</b> {p.raised(text)}'
        + (f'<span class="reason">{escape(over)}</span>' if over else "")
        + "</p>"
        for figure, text, over in statements(data, found).values()
    )
    rows = [row for row in (data.pick(found.row.scene, found.row.level, label) for label in SHOWN) if row]
    wide, narrow = picture.charts(rows)
    text = "Bytes a quad, speed relative to GRID and error of each representation"
    figure = p.chart(wide, text, narrow, caption(data, found, rows))
    return f'<div class="results">{cells}</div><div class="charts one">{figure}</div>'
