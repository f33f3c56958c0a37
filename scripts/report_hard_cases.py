# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The table of hard cases: what their tests say that holds, and whether it does.

scripts/test.sh leaves one XML file of GoogleTest a case, representation and
instruction set; the sentence is the test's own.
"""

import re
import xml.etree.ElementTree as xml
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

import report_page as p
# The tests' name of a kind, and ours: their cLEAF has leaves for all faces.
COMPRESSED = {"cGRID": "cGRID", "cVOXEL": "cVOXEL", "cLEAF": "cLEAF-only", "cVERT": "cVERT"}
MADE_BY = "scripts/test.sh -R 'hard_cases|invalid_vertices'"


@dataclass
class Case:
    name: str
    sentence: str
    results: dict = field(default_factory=dict)  # (representation, instruction set): passed, failed, skipped


def read(folder):
    """Cases in the order of their names; those of no representation have results of ("", "")."""
    cases = {}
    for path in sorted(Path(folder).rglob("*.xml")):
        try:
            tests = xml.parse(path).getroot().iter("testcase")
        except xml.ParseError:
            continue  # a test that was stopped while it wrote: as if not run
        for test in tests:
            sentence = test.find("./properties/property[@name='property']")
            if sentence is None:
                continue
            suite = test.get("classname").split("/")[-1]
            name, _, tracer = test.get("name").partition("/")
            kind, _, isa = tracer.partition("_")
            case = cases.setdefault((suite, name), Case(f"{suite}.{name}", sentence.get("value")))
            failed, skipped = test.find("failure") is not None, test.find("skipped") is not None
            case.results[kind, isa] = "failed" if failed else "skipped" if skipped else "passed"
    return [cases[key] for key in sorted(cases)]


def cell(case, kind):
    results = {isa: result for (k, isa), result in case.results.items() if k in (kind, "")}
    failed = [isa for isa, result in results.items() if result == "failed"]
    passed = [isa for isa, result in results.items() if result == "passed"]
    if failed:
        return f'<span class="no">fails{escape(": " + ", ".join(failed) if failed[0] else "")}</span>'
    if passed:
        return f'<span class="yes">holds{f" ({len(passed)})" if passed[0] else ""}</span>'
    return '<span class="none">not run</span>'


def breakable(name):
    """A test's name, which may go on in the next line before each of its words."""
    return re.sub(r"(?<=[a-z0-9.])(?=[A-Z])", "<wbr>", escape(name))


def section(folder):
    title = "Hard cases"
    cases = read(folder)
    if not cases:
        return p.section("hard", title, p.missing(f"{MADE_BY} runs them"))
    isas = sorted({isa for case in cases for _, isa in case.results if isa})
    results = [result for case in cases for result in case.results.values()]
    text = (
        f"<p>{len(cases)} cases; each is a test of every representation on every instruction set that is built in "
        f"({escape(', '.join(isas))}): {results.count('passed')} of {len(results)} tests pass, "
        f"{results.count('failed')} fail, {results.count('skipped')} were skipped, as this machine lacks the "
        "instruction set. The number says on how many a case holds.</p>"
    )
    rows = [[breakable(c.name), escape(c.sentence), *(cell(c, kind) for kind in COMPRESSED)] for c in cases]
    heads = ["case", "property", *(p.label(label) for label in COMPRESSED.values())]
    return p.section("hard", title, text, p.table(heads, rows, text_columns=(0, 1)), commands=[MADE_BY])
