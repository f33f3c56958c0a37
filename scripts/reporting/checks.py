# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Leaks, crossed sheets and self-shadowing from the benchmark, and the hard cases of the tests. scripts/test.sh writes
an XML file of GoogleTest for each case, representation and instruction set. The sentence that describes a case comes
from the test."""

import xml.etree.ElementTree as xml
from pathlib import Path

from .data import in_order
from .formats import Table, table

# Names of representations in the tests and here. The tests use cLEAF with leaves for all faces.
COMPRESSED = {"cGRID": "cGRID", "cVOXEL": "cVOXEL", "cLEAF": "cLEAF-only", "cVERT": "cVERT"}
COMMAND = "scripts/test.sh --all-isas -R 'hard_cases|invalid_vertices'"


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
SHADOWS += [("rays flipped", lambda row: 1000 * row.shadow_flipped_rays / max(1, row.shadow_rays), "{:.3f}")]


def tables(frame):
    """Tables of leaks, sheets and shadows, as far as they were measured."""
    rows = in_order(frame, "scene", "level", "representation", "job")
    once, shadows = rows.drop_duplicates("result"), rows[rows.what == "shadow"]
    found = [table(once[once.leaks_rays.notna()], LEAKS, 1, "Leaks")]
    found += [table(once[once.sheets_rays.notna()], SHEETS, 1, "Crossed sheets")]
    return [one for one in [*found, table(shadows, SHADOWS, 3, "Shadows, per thousand rays")] if one.rows]


def section(data):
    rows = data.table[(data.table.origin == "here") & (data.table.what != "skipped")]
    rows = rows[rows.leaks_rays.notna() | rows.sheets_rays.notna() | (rows.what == "shadow")]
    return tables(rows), rows.command


def read_tests(folder):
    """Returns {(case, sentence): {(kind, instruction set): passed, failed or skipped}}. Tests without a kind have ("",
    "")."""
    cases = {}
    for path in sorted(Path(folder).rglob("*.xml")):
        try:
            tests = list(xml.parse(path).getroot().iter("testcase"))
        except xml.ParseError:
            continue  # incomplete because the test was interrupted: counts as not run
        for test in [test for test in tests if test.find("./properties/property[@name='property']") is not None]:
            name, _, tracer = test.get("name").partition("/")
            kind, _, isa = tracer.partition("_")
            results = {"failed": test.find("failure"), "skipped": test.find("skipped"), "passed": test}
            case = test.get("classname").split("/")[-1], name, test.find("./properties/property").get("value")
            result = next(name for name, found in results.items() if found is not None)
            cases.setdefault((".".join(case[:2]), case[2]), {})[kind, isa] = result
    return dict(sorted(cases.items()))


def verdict(results, kind):
    """Verdict on a case and a kind: whether it holds, and on how many instruction sets."""
    found = {isa: result for (of, isa), result in results.items() if of in (kind, "")}
    failed, passed = ([isa for isa, result in found.items() if result == what] for what in ("failed", "passed"))
    if failed:
        return "fails" + (f": {', '.join(failed)}" if failed[0] else "")
    return ("holds" + (f" ({len(passed)})" if passed[0] else "")) if passed else "not run"


def hard_cases(folder):
    cases = read_tests(folder)
    results = [result for case in cases.values() for result in case.values()]
    isas = sorted({isa for case in cases.values() for _, isa in case if isa})
    counts = ", ".join(f"{results.count(what)} {what}" for what in ("passed", "failed", "skipped"))
    text = f"{len(cases)} cases, {len(results)} tests on {', '.join(isas)}: {counts}."
    rows = [[name, sentence, *(verdict(of_case, kind) for kind in COMPRESSED)]
            for (name, sentence), of_case in cases.items()]  # fmt: skip
    return [text, Table(["case", "property", *COMPRESSED.values()], rows, 2)] if cases else [], [COMMAND]
