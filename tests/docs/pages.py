#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks that links of the pages in Markdown, and paths in code quotes, lead to files and headings that exist. Paths in
architecture.md may be short."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(
    [*ROOT.glob("*.md"), *(page for folder in ("docs", "kernels", "tests") for page in ROOT.glob(f"{folder}/**/*.md"))]
)
SHORT_PATH = re.compile(r"`([\w-]+/[\w./-]+\.(?:h|cpp|glsl|cmake))`")
# Folders that short paths begin in.
FOLDERS = [ROOT / folder for folder in (".", "include", "kernels", "kernels/cbvh", "kernels/cvert")]
PATH = re.compile(r"`((?:common|docs|include|kernels|scripts|tests|tutorials)/[\w./-]+)[^`]*`")


def prose_of(page):
    """Yields the number and the text of each line outside of code."""
    code = False
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        fence = re.match(r"\s*```", line)
        code ^= bool(fence)
        if not code and not fence:
            yield number, line


def anchors_of(page):
    """Targets of #links into a page: its headings, abbreviated as by GitHub, and its explicit anchors."""
    lines = [line for _, line in prose_of(page)]
    titles = [line.lstrip("#").strip().lower() for line in lines if line.startswith("#")]
    explicit = [name for line in lines for name in re.findall(r'<a id="([^"]+)">', line)]
    return {re.sub(r"[^\w\- ]", "", title).replace(" ", "-") for title in titles} | set(explicit)


def broken(page):
    """Yields the lines and targets of broken links and paths."""
    for number, line in prose_of(page):
        for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", line)):
            path, _, anchor = target.partition("#")
            other = (page.parent / path).resolve() if path else page
            if not re.match(r"[a-z]+:", target) and not (
                other.exists() and (not anchor or anchor in anchors_of(other))
            ):
                yield number, target
        if page.name != "CHANGELOG.md":  # it may name files of the past
            yield from ((number, path) for path in PATH.findall(line) if not (ROOT / path).exists())
        if page.name == "architecture.md":
            for path in SHORT_PATH.findall(line):
                if not any((folder / path).exists() for folder in FOLDERS):
                    yield number, path


found = [f"{page.relative_to(ROOT)}:{number}: {target}" for page in PAGES for number, target in broken(page)]
print("\n".join([*found, f"{len(PAGES)} pages, {len(found)} broken links"]))
sys.exit(1 if found or len(PAGES) < 2 else 0)
