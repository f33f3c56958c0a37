#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Writes docs/figures.md from docs/figures.csv, the measured figures that pages state in their prose.

    scripts/figures.py            writes the page
    scripts/figures.py --check    exits with 1 if the page differs, if a page links to a figure that does not exist or
                                  has another value, or if no page links to a figure

A page states a figure as [9 to 16 times](figures.md#memory). The text of the link must contain the value in the table.
"""

import argparse
import csv
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TABLE, PAGE = ROOT / "docs/figures.csv", ROOT / "docs/figures.md"
LINK = re.compile(r"\[([^\]]*)\]\([^)\s]*figures\.md#([\w-]+)\)")
INTRODUCTION = """# Figures

After this page you know how each figure that other pages link to was measured. Terms are defined in
[vocabulary.md](vocabulary.md). Tables and generated text on other pages name their command and machine themselves.

An empty cell means "not recorded". "Commit" is the version that was measured. If it was not recorded, the column has
"by" and the commit that published the figure. `scripts/figures.py` writes this page from `docs/figures.csv`, which is
edited by hand.

## How do I reproduce a figure?

Build the preset `release` and run the command. Programs named `cbvh_*` are below `build/release/tutorials`, programs
named `test_*` and `capi_*` below `build/release/tests`. Scripts explain their arguments with `--help`. If the table
omits options, look on the page that links to the figure. Figures without a command cannot be repeated, nor tables that
name `body_hm08`: this model is not in the repository.

## Which figures are there?

| machine | properties that were recorded |
|:--|:--|
| EPYC AVX2 | AMD, two cores, 512 KiB of L2, 8 MiB of L3 |
| EPYC AVX-512 | AMD, two cores, 1 MiB of L2, 32 MiB of L3 |
| Xeon AVX-512 | Intel, two cores |
| Xeon 2.50 GHz | Intel, AVX-512 |
| NVIDIA H100 | driver 580.159 |
| lavapipe | Mesa's software implementation of Vulkan |
"""


def figures():
    """Returns the rows of the table, as dictionaries by column."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def page_of(rows):
    """Returns the page as Markdown."""
    lines = [INTRODUCTION, "| figure | meaning | command | machine | commit | date |", "|--:|:--|:--|:--|:--|:--|"]
    for row in rows:
        figure = f'<a id="{row["id"]}"></a>{row["value"]}'
        command = f"`{row['command']}`" if row["command"] else ""
        cells = [figure, row["meaning"], command, row["machine"], row["commit"], row["date"]]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def findings(rows):
    """Yields a line for each error in the table, and for each link that does not fit the table."""
    values = {row["id"]: row["value"] for row in rows}
    if len(values) < len(rows):
        yield f"{TABLE.name}: two figures have the same id"
    for row in rows:
        if None in row or None in row.values():
            yield f"{TABLE.name}: {row['id']}: expected {len(rows[0])} columns"
        elif not all(row[column] for column in ("value", "meaning", "commit", "date")):
            yield f"{TABLE.name}: {row['id']}: expected a value, a meaning, a commit and a date"
    unused = set(values)
    for page in sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("tutorials/**/*.md")]):
        for match in LINK.finditer(page.read_text(encoding="utf-8")):
            text, name = " ".join(match[1].split()), match[2]
            unused.discard(name)
            if name not in values:
                yield f"{page.relative_to(ROOT)}: #{name} is not in {TABLE.name}"
            elif not re.search(rf"(?<![\w.,]){re.escape(values[name])}(?!\w|[.,]\d)", text):
                yield f"{page.relative_to(ROOT)}: '{text}': the value of #{name} in {TABLE.name} is {values[name]}"
    yield from (f"{TABLE.name}: no page links to #{name}" for name in sorted(unused))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare only")
    options = parser.parse_args()
    rows = figures()
    if not options.check:
        PAGE.write_text(page_of(rows), encoding="utf-8")
        return 0
    found = list(findings(rows))
    if not PAGE.exists() or PAGE.read_text(encoding="utf-8") != page_of(rows):
        found.append(f"{PAGE.relative_to(ROOT)} differs from {TABLE.name}: run scripts/figures.py")
    print("\n".join([*found, f"{len(rows)} figures, {len(found)} findings"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
