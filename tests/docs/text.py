#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks all text that git tracks: lines of at most 120 columns, words and spelling of comments and pages.

Exits with 0 if there are no findings, with 1 if there are, and with 77 (skipped) outside of a git repository.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OTHERS = re.compile(r"\.(patch|abi|jpg|cbvh)$|^LICENSE|patches/series$|tests/docs/text\.py$")  # not our text
ACCEPTED = "bu,froms,inout,lod,nd,requestor,threds"  # words that codespell does not know
PROSE = re.compile(r"(?:(?<![:\w])(?://|#(?!include|define|if|el|en))|^\s*/?\*+ )(.*)")  # of code: comments
DIALECT = {
    r"\bnobody\b|\bwhoever\b|\. Who\b(?!.*\?)": "name the subject",
    r"\bof which\b|\bthe same of\b": "repeat the noun",
    r"\balike\b|\bbeside (the|a|an|its|our|their|this|Embree)\b": '"the same", "next to"',
    r"\b(bytes?|bits?|rays?|words?) an? (quad|ray|triangle|vertex|pixel|block|group|node)\b": '"per quad"',
    r"\bto be had\b|\bis told\b|\btells\b|\bbecomes? ours\b": "say what it does",
    r"\b(colour|behaviour|neighbour|favour)\w*|\b\w*(optimis|initialis|normalis|minimis|quantis)(e[sd]?|ing|ation)\b|"
    r"\b(grey|cancelled|labelled|catalogue|analyse)\b(?!\.h)": "American spelling",
}

listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True) if shutil.which("git") else None
if not listed or listed.returncode:
    sys.exit(77)
names = [name for name in listed.stdout.split("\n") if (ROOT / name).is_file() and not OTHERS.search(name)]
found = []
for name in names:
    page = name.endswith(".md")
    for number, line in enumerate((ROOT / name).read_text(encoding="utf-8").split("\n"), 1):
        if len(line) > 120 and not (page and re.search(r"^\||\]\(|https?:", line)):  # tables and links do not wrap
            found.append(f"{name}:{number}: {len(line)} columns, at most 120 are allowed")
        comment = PROSE.search(line)
        text = re.sub(r"`[^`]*`", "code", line) if page else comment[1] if comment else ""
        found += [f"{name}:{number}: write {advice}: {text}" for bad, advice in DIALECT.items() if re.search(bad, text)]
if shutil.which("codespell"):  # camelCase: names are not words
    command = ["codespell", "-L", ACCEPTED, "--ignore-regex", r"\b[a-z]+[A-Z]\w*\b", *names]
    found += subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.splitlines()
print("\n".join([*found, f"{len(names)} files, {len(found)} findings"]))
sys.exit(1 if found else 0)
