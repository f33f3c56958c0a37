# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The last section of the report: what was measured where and when, and how noisy it was."""

from html import escape

import report_data as d
import report_page as p


def several(values):
    return escape("; ".join(dict.fromkeys(values))) or "-"


def facts(data, source):
    """(name, HTML) of each."""
    runs = data.runs
    loads = [run["load_before"] for run in runs]
    dates = [d.period(runs)] if runs else []
    processors = [
        f"{run['cpu']}, {run['hardware_threads']} threads, {run['memory_bytes'] / 2**30:.0f} GiB" for run in runs
    ]
    return [
        ("measured", several(dates)),
        ("commit", several(run["commit"] for run in runs)),
        ("processor", several(processors)),
        ("instruction set", escape(data.isa or "-")),
        ("compiler", several(f"{run['compiler']}, {run['build_type']} {run['flags']}" for run in runs)),
        ("load before", f"{min(loads):.1f} to {max(loads):.1f} runnable threads" if loads else "-"),
        ("records", f"{len(runs)} in <code>{escape(source)}</code>, made by <code>scripts/benchmark.py</code>"),
    ]


def noise_text(data, against):
    found = d.noise(data.rows)
    if not found:
        return f"<p>No speeds were measured{' but those of the section on GPUs' if data.gpu else ''}.</p>"
    text = (
        "<p><b>Noise.</b> The middle half of the ratios to GRID of a combination spreads by "
        f"{100 * found['median']:.1f}% (median of {found['count']} combinations; the worst {100 * found['max']:.0f}%, "
        f"{found['beyond']} beyond 5%): {d.judged(found)}. By that, a median is good to {100 * found['unsure']:.1f}%, 95 of 100 "
        f"to {100 * found['unsure_95']:.1f}%, and ratios that are closer do not differ. One thread is timed by its "
        "processor time, so other programs cost caches and clock, not turns: that hits GRID, which has more to cache, "
        "harder, and may differ from run to run. How far a second run is apart, <code>--against</code> says. The spread "
        "of each ratio is in the table of all speeds.</p>"
    )
    return text + (two_runs_text(data, against) if against is not None else "")


def two_runs_text(data, against):
    apart = d.compare_runs(data, against)
    if not apart:
        return "<p><b>Two runs.</b> They have no measurement in common.</p>"
    good = "less than 5%" if apart["beyond"] == 0 else f"{apart['beyond']} of them by more than 5%"
    return (
        f"<p><b>Two runs.</b> Medians of ratios to GRID of {apart['count']} combinations differ by "
        f"{100 * apart['median']:.1f}% (median), 95 of 100 by less than {100 * apart['p95']:.1f}%, and at most "
        f"{100 * apart['max']:.1f}%: {good}.</p>"
    )


def problems(data):
    return "".join(f'<p class="missing">{escape(problem)}; left out</p>' for problem in data.problems)


def section(data, against, source):
    """source: name of the folder of the records."""
    terms = "".join(f"<dt>{name}</dt><dd>{value}</dd>" for name, value in facts(data, source))
    return p.section("run", "The run, and its noise", f"<dl>{terms}</dl>", problems(data), noise_text(data, against))
