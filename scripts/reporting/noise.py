# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The run: machine, date, and noise of its speeds."""

COMBINATION = ["job", "scene", "level", "representation", "isa", "view", "ray_set", "query", "mode", "threads"]


def period(runs):
    """From the start of the first run to the end of the last. Older records have no end."""
    begin, end = min(run["date"] for run in runs), max(run.get("end", run["date"]) for run in runs)
    return begin if begin == end else f"{begin} to {end}"


def uncertainty(spread, rounds):
    """Twice the standard deviation of the median of the ratios to GRID, relative to the median, for normally
    distributed noise. The interquartile range of a normal distribution is 1.35 standard deviations; the standard
    deviation of the median of n is 1.25 / sqrt(n)."""
    return 2 * 1.25 * spread / 1.35 / rounds**0.5


def speeds(table):
    """Rows of speeds that have ratios to GRID's. Devices without a clock have none."""
    return table[(table.what == "speed") & (table.kind != "GRID") & table.relative_to_grid_spread.notna()]


def noise(table):
    """A sentence on the spread of ratios to GRID and on the accuracy of their medians."""
    spread, rounds = speeds(table).relative_to_grid_spread, speeds(table).seconds.map(len)
    if spread.empty:
        return "No speeds were measured."
    unsure, beyond = uncertainty(spread, rounds), (spread > 0.05).sum()
    noisy = "some noise" if spread.median() < 0.05 else "a noisy run, its speeds are rough"
    return (
        f"Noise: the middle half of the ratios to GRID of a combination spreads by {spread.median():.1%} (median of "
        f"{len(spread)} combinations; the worst {spread.max():.0%}, {beyond} beyond 5%): "
        f"{'a quiet run' if beyond < 0.1 * len(spread) else noisy}. By that, medians are good to {unsure.median():.1%}"
        f", 95 of 100 to {unsure.quantile(0.95):.1%}, and ratios that are closer do not differ."
    )


def compare_runs(table, other):
    """Relative differences between the median ratios to GRID of two runs."""
    pairs = speeds(table).merge(speeds(other).drop_duplicates(COMBINATION), "inner", COMBINATION)
    a, b = pairs.relative_to_grid_median_x, pairs.relative_to_grid_median_y
    return (a - b).abs() / (0.5 * (a + b))


def section(data, against, source):
    """Facts, records that could not be read, and noise. source: name of the folder of the records."""
    runs, loads = data.runs, [run["load_before"] for run in data.runs] or [0.0]
    found = {
        "measured": [period(runs)] if runs else [], "commit": [run["commit"] for run in runs],
        "processor": ["{cpu}, {hardware_threads} threads".format(**run) for run in runs],
        "memory": [f"{run['memory_bytes'] / 2**30:.0f} GiB" for run in runs],
        "compiler": [f"{run['compiler']}, {run['build_type']} {run['flags']}" for run in runs],
        "load before": [f"{min(loads):.1f} to {max(loads):.1f} runnable threads"], "instruction set": [data.isa],
        "records": [f"{len(runs)} in {source}, made by scripts/benchmark.py"],
    }  # fmt: skip
    facts = {name: "; ".join(dict.fromkeys(values)) for name, values in found.items()}
    parts = [facts, *(f"No data: {problem}; left out" for problem in data.problems), noise(data.here)]
    changes = compare_runs(data.here, against.here) if against else None
    if changes is not None:
        ends = f"{changes.quantile(0.95):.1%}, and at most {changes.max():.1%}"
        ends += f": {(changes > 0.05).sum()} by more than 5%."
        text = f"Two runs: medians of ratios of {len(changes)} combinations differ by {changes.median():.1%} (median)"
        parts.append(f"{text}, 95 of 100 by less than {ends}" if len(changes) else "Two runs have nothing in common.")
    return parts, []
