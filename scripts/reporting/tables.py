# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Tables of the processor: memory, speed and errors of each scene, functions of the API, instruction sets, checks, the
hard cases of the tests, and the run with its noise."""

import xml.etree.ElementTree as xml
from pathlib import Path

from .data import ISAS, RAY_SETS, in_order
from .formats import Table, percent, pixels, signed, table

WHERE = [("level", "level", str), ("", "representation", str)]


def fallback_share(row):
    """Share of cLEAF's quads that are stored as cVERT; None for other representations."""
    return row.memory_compression_fallback_quads / max(1, row.memory_compression_quads) if row.kind == "cLEAF" else None


BUILDS = [
    *WHERE, ("MiB", "mib", "{:.2f}"), ("bytes per quad", "memory_bytes_per_quad", "{:.2f}"),
    ("stored as cVERT", fallback_share, percent), ("of GRID", "part_of_grid", percent),
    ("peak, MiB", lambda row: row.memory_peak_bytes / 2**20, "{:.1f}"), ("build, s", "build_seconds", "{:.3f}"),
]  # fmt: skip
for rays in RAY_SETS:
    BUILDS += [(f"{rays}, Mrays/s", rays, "{:.3f}"), (f"{rays}, of GRID", f"{rays}_of_grid", "{:.2f}")]
ERRORS = [
    *WHERE, ("view", "view", str), ("median", "errors_median_pixels", pixels), ("p99", "errors_p99_pixels", pixels),
    ("max", "errors_max_pixels", pixels), ("rays beyond 5 pixels", "errors_beyond_5_pixels", "{:.0f}"),
    ("bias of the others", "errors_bias_pixels", signed), ("false hits", "errors_false_hits", "{:.0f}"),
    ("misses", "errors_misses", "{:.0f}"), ("the paper's RMSE", "errors_rmse_pixels", pixels),
    ("true surface: median", "errors_to_true_surface_median_pixels", pixels),
    ("true surface: p99", "errors_to_true_surface_p99_pixels", pixels),
]  # fmt: skip
PLACE = [("", lambda row: f"{row.scene} {row.representation}, level {row.level}", str), ("view", "view", str)]
PLACE += [("rays", "ray_set", str), ("query", "query", str), ("threads", "threads", "{:.0f}")]
MODES = ("single", "packet4", "packet8", "packet16", "stream")


def of_scene(data, scene):
    """Memory, build and speed, and errors in pixels to GRID's hits and to the true surface."""
    rows = data.full[data.full.scene == scene]
    grid = rows[rows.kind == "GRID"].set_index("level").mib
    rows = rows.assign(part_of_grid=rows.mib / rows.level.map(grid))
    errors = table(data.views(scene=scene), ERRORS, 3, f"{scene}: errors, pixels")
    return [table(rows, BUILDS, 2, f"{scene}: memory, build and speed"), errors]


def entrances(data):
    """Speeds of each function of the API: millions per second, and percent of GRID's speed with the same function."""
    rows = data.of_isa[data.of_isa.what == "speed"]
    keys = ["scene", "level", "representation", "view", "ray_set", "query"]
    rows = rows[rows.job.isin(("entrances", "threads")) | rows.result.isin(rows[rows["mode"] != "single"].result)]
    text = rows.mrays_per_second_median.map("{:.2f}".format) + rows.relative_to_grid_median.map(" ({:.0%})".format)
    wide = rows.assign(text=text).pivot_table("text", [*keys, "threads"], "mode", aggfunc="first")
    wide = in_order(wide.reindex(columns=MODES).reset_index(), *keys, "threads")
    return [table(wide, [*PLACE, *((mode, mode, str) for mode in MODES)], 4)] if len(wide) else []


def isas(data):
    """Single rays, closest hit, one thread, full view, of scenes that several instruction sets or CPUs measured, on
    this and on other machines."""
    rows = data.every_view
    rows = rows[(rows.origin == "elsewhere") | rows.result.isin(data.here.result)]
    rows = rows[(rows["view"] == "full") & (rows["speeds"] > 0)]
    columns = [*WHERE, ("instruction set", "isa", str), ("processor", "run_cpu", str), ("commit", "run_commit", str)]
    for rays in RAY_SETS:
        columns += [(f"{rays}, Mrays/s", rays, "{:.2f}"), (f"{rays}, of GRID", f"{rays}_of_grid", "{:.2f}")]
    parts = []
    for (scene, _), found in rows.groupby(["scene", "level"]):
        if len(found[["isa", "run_cpu"]].drop_duplicates()) > 1:
            found = found.drop_duplicates(["run_cpu", "isa", "representation"], keep="last")
            found = found.assign(rank=found.isa.map(ISAS.index))
            parts.append(table(in_order(found, "representation", "rank", "run_cpu"), columns, 5, scene))
    return parts


# --- checks --------------------------------------------------------------------------------------


def place(row):
    position = row.run_settings_position
    far = " at " + ", ".join(f"{x:.0f}" for x in position) if any(position) else ""
    return f"{row.scene} {row.representation}, level {row.level}{far}"


DARK = ("false_occlusions", "false_passes")


def per_thousand(errors, rays="rays", keys=DARK):
    """Returns a function that computes how many of a thousand of these rays have errors of these keys."""
    return lambda row: 1000 * sum(row[f"shadow_{errors}_{key}"] for key in keys) / max(1, row[f"shadow_{rays}"])


QUERIES = {"closest": "closest", "any hit": "any", "through": "through"}
LEAKS = [("", place, str), ("rays", "leaks_rays", "{:,.0f}")]
LEAKS += [(head, f"leaks_missed_{key}", "{:.0f}") for head, key in QUERIES.items()]
LEAKS += [(f"GRID: {head}", f"leaks_missed_by_grid_{key}", "{:.0f}") for head, key in QUERIES.items()]
CROSSED = {"sheets": "sheets", "rays": "rays", "closest": "closest", "any hit": "any", "GRID, too": "missed_by_grid"}
SHEETS = [("", "representation", str), *((head, f"sheets_{key}", "{:,.0f}") for head, key in CROSSED.items())]
ERROR_RATES = {"wrong": ("errors",), "dark": ("errors", "rays", DARK[:1]), "bright": ("errors", "rays", DARK[1:])}
ERROR_RATES |= {"same hit": ("same_hit_errors", "same_hit_rays"), "flipped": ("flipped_errors", "flipped_rays")}
ERROR_RATES |= {"control": ("control_errors",)}
SHADOWS = [("", place, str), ("offset", "shadow_offset", str)]
SHADOWS += [("rays", lambda row: "short" if row.shadow_length > 0 else "infinite", str)]
SHADOWS += [(head, per_thousand(*errors), "{:.3f}") for head, errors in ERROR_RATES.items()]


def checks(data):
    """Tables of leaks, sheets and shadows, on processors and devices, as far as they were measured."""
    rows = in_order(data.table[data.table.what != "skipped"], "scene", "level", "representation", "job")
    once = rows.drop_duplicates("result")
    found = [table(once[once.leaks_rays.notna()], LEAKS, 1, "Leaks: rays from inside of closed surfaces that miss")]
    found += [table(once[once.sheets_rays.notna()], SHEETS, 1, "Rays through random sheets that miss")]
    shadows = table(rows[rows.what == "shadow"], SHADOWS, 3, "Shadows that differ from GRID's, per thousand rays")
    return [one for one in [*found, shadows] if one.rows]


def hard_cases(folder):
    """Counts of results of each hard case. scripts/test.sh writes an XML file of GoogleTest for each case, kind and
    instruction set; the sentence that describes a case comes from the test."""
    cases = {}
    for path in sorted(Path(folder).rglob("*.xml")):
        try:
            tests = list(xml.parse(path).getroot().iter("testcase"))
        except xml.ParseError:
            continue  # incomplete because the test was interrupted: counts as not run
        for test in tests:
            sentence = test.find("./properties/property[@name='property']")
            if sentence is not None:
                case = test.get("classname").split("/")[-1] + "." + test.get("name").partition("/")[0]
                result = next((what for what in ("failure", "skipped") if test.find(what) is not None), "passed")
                counts = cases.setdefault(
                    (case, sentence.get("value")), dict.fromkeys(("passed", "failure", "skipped"), 0)
                )
                counts[result] += 1
    rows = [[*case, *map(str, counts.values())] for case, counts in sorted(cases.items())]
    return [Table(["case", "property", "passed", "failed", "skipped"], rows, 2)] if rows else []


# --- the run -------------------------------------------------------------------------------------

COMBINATION = ["job", "scene", "level", "representation", "isa", "view", "ray_set", "query", "mode", "threads"]


def noise(table_):
    """A sentence on the spread of ratios to GRID and on the accuracy of their medians: twice the standard deviation of
    the median of n normally distributed ratios, whose interquartile range is 1.35 standard deviations, is 2 * 1.25 /
    1.35 / sqrt(n) times that range."""
    rows = table_[(table_.what == "speed") & (table_.kind != "GRID") & table_.relative_to_grid_spread.notna()]
    if rows.empty:
        return "No speeds were measured."
    spread, unsure = rows.relative_to_grid_spread, rows.relative_to_grid_spread / rows.seconds.map(len) ** 0.5 * 1.85
    return (
        f"Noise: the middle half of the ratios to GRID of a combination spreads by {spread.median():.1%} (median of "
        f"{len(rows)} combinations, at most {spread.max():.0%}). Medians are good to {unsure.median():.1%}, 95 of 100 "
        f"to {unsure.quantile(0.95):.1%}; ratios that are closer do not differ."
    )


def run(data, against=None):
    """Machine, date, records that could not be read, noise, and differences from another run."""
    facts = [f"- {name}: {'; '.join(dict.fromkeys(values))}" for name, values in (
        ("measured", [f"{run['date']} to {run.get('end', run['date'])}" for run in data.runs[:1] + data.runs[-1:]]),
        ("commit", [run["commit"] for run in data.runs]), ("instruction set", [data.isa]),
        ("processor", ["{cpu}, {hardware_threads} threads".format(**run) for run in data.runs]),
        ("compiler", [f"{run['compiler']}, {run['build_type']} {run['flags']}" for run in data.runs]),
        ("load before", [f"{run['load_before']:.1f} runnable threads" for run in data.runs]),
    )]  # fmt: skip
    parts = ["\n".join(facts), *(f"Left out: {problem}" for problem in data.problems), noise(data.here)]
    if against:
        pairs = data.here.merge(against.here.drop_duplicates(COMBINATION), "inner", COMBINATION)
        a, b = pairs.relative_to_grid_median_x, pairs.relative_to_grid_median_y
        changes = ((a - b).abs() / (0.5 * (a + b))).dropna()
        text = f"Two runs: medians of ratios of {len(changes)} combinations differ by {changes.median():.1%} (median)"
        parts.append(f"{text}, at most by {changes.max():.1%}." if len(changes) else "Two runs have nothing in common.")
    return parts
