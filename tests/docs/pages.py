#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks the pages in Markdown: links and paths lead to files that exist, pages are short, and the diagram of the
folders matches the code. prose.py checks their text.

    pages.py
"""

import re
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])
MOST_WORDS = {"README.md": 900, "docs/architecture.md": 2000}  # other pages in docs/ have at most 1500
FENCE = re.compile(r"^\s*```")


def name_of(page):
    return str(page.relative_to(ROOT))


def lines_of(page):
    """Yields the number and the text of each line, and whether the line is code."""
    code = False
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if FENCE.match(line):
            code = not code
            yield number, line, True
        else:
            yield number, line, code


def words_of(page):
    """Number of words: runs without blanks or bars of a table that have a letter or a digit."""
    return sum(1 for word in page.read_text(encoding="utf-8").replace("|", " ").split() if re.search(r"\w", word))


def anchors_of(page):
    """Targets of #links into a page: its headings, abbreviated as by GitHub, and its explicit anchors."""
    anchors = set()
    for _, line, code in lines_of(page):
        heading = re.match(r"#+ (.*)", line)
        if heading and not code:
            anchors.add(re.sub(r"[^\w\- ]", "", heading.group(1).lower()).replace(" ", "-"))
        anchors.update(re.findall(r'<a id="([^"]+)">', line))
    return anchors


def links_of(page):
    """Yields the line and the target of each link or picture that is not on the web."""
    for number, line, code in lines_of(page):
        if not code:
            for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", line)):
                if not re.match(r"[a-z]+:", target):
                    yield number, target


class Pages(unittest.TestCase):
    def test_there_are_pages(self):
        self.assertGreater(len(PAGES), 15)

    def test_links_lead_somewhere(self):
        broken = []
        for page in PAGES:
            for number, target in links_of(page):
                path, _, anchor = target.partition("#")
                other = (page.parent / path).resolve() if path else page
                if not other.exists() or (anchor and anchor not in anchors_of(other)):
                    broken.append(f"{name_of(page)}:{number}: {target}")
        self.assertEqual(broken, [])

    def test_paths_in_code_quotes_exist(self):
        """Paths such as `kernels/...` and `tests/...` must name files or folders of the repository."""
        missing = []
        top = ("common", "docs", "include", "kernels", "scripts", "tests", "tutorials")
        for page in PAGES:
            if page.name == "CHANGELOG.md":  # it may name files of the past
                continue
            for number, line, code in lines_of(page):
                for path in [] if code else re.findall(r"`((?:%s)/[\w./-]+)[^`]*`" % "|".join(top), line):
                    if not (ROOT / path).exists():
                        missing.append(f"{name_of(page)}:{number}: {path}")
        self.assertEqual(missing, [])

    def test_pages_are_short_enough_to_read(self):
        long = []
        for page in PAGES:
            most = MOST_WORDS.get(name_of(page), 1500 if page.is_relative_to(ROOT / "docs") else None)
            if most and words_of(page) > most:
                long.append(f"{name_of(page)}: {words_of(page)} words, at most {most}")
        self.assertEqual(long, [])

    def test_every_page_is_linked_from_another(self):
        linked = {(page.parent / target.partition("#")[0]).resolve() for page in PAGES for _, target in links_of(page)}
        lonely = [name_of(page) for page in PAGES if page.is_relative_to(ROOT / "docs") and page not in linked]
        self.assertEqual(lonely, [])

    def test_the_picture_of_the_folders_shows_the_code(self):
        command = [sys.executable, "-B", ROOT / "scripts/draw_includes.py", "--check"]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()
