#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks the text of all files in the repository: comments, docstrings, messages and pages.

    prose.py lines       no line is longer than 120 columns
    prose.py dialect     no phrase of dialect.txt occurs in comments, strings or pages
    prose.py spelling    codespell finds no error, except for the words of spelling.txt

The files are those that git tracks, and new ones that it does not ignore. Exits with 0 if there are no findings, with 1
if there are, and with 77 (skipped) outside of a git repository.
"""

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
MAX_COLUMNS = 120
SKIPPED = 77
C_LIKE = (".h", ".cpp", ".c", ".glsl", ".comp", ".rint")
HASH_LIKE = (".py", ".sh", ".cmake", "CMakeLists.txt", ".h.in", "scripts/packages", ".ci/run")
# text of others, and data: patches with lines of Embree, an ABI that abidw wrote, licenses, pictures, compressed files
NOT_OURS = ("*.patch", "*.abi", "LICENSE", "kernels/upstream/patches/series", "*.jpg", "*.cbvh")
# the rejected phrases, accepted words that codespell does not know, and examples of both
LISTS = ("tests/docs/dialect.txt", "tests/docs/spelling.txt", "tests/docs/prose_parser.py")


def entries_of(name):
    """Lines of a list in this folder, without comments and empty lines."""
    lines = (HERE / name).read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def files():
    """Paths of the files to check, relative to the root. None without git or outside of a git repository."""
    if not shutil.which("git"):
        return None
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        return None
    paths = sorted({Path(name) for name in done.stdout.split("\0") if name})
    return [
        path
        for path in paths
        if (ROOT / path).is_file() and str(path) not in LISTS and not any(path.match(pattern) for pattern in NOT_OURS)
    ]


def read(path):
    return (ROOT / path).read_text(encoding="utf-8")


# --- lines ------------------------------------------------------------------------------------


def long_lines(path):
    """Lines of more than 120 characters. Tables and links of Markdown cannot be wrapped."""
    for number, line in enumerate(read(path).splitlines(), 1):
        fixed = path.suffix == ".md" and (line.startswith("|") or re.search(r"\]\(\S+\)|https?:", line))
        if len(line) > MAX_COLUMNS and not fixed:
            yield number, f"{len(line)} columns, at most {MAX_COLUMNS} are allowed"


# --- dialect ----------------------------------------------------------------------------------

# One alternative each for raw strings, strings, characters and comments. Apostrophes in numbers (1'000) are skipped.
C_TOKEN = re.compile(
    r'R"(?P<mark>[^(\s]*)\((?P<raw>.*?)\)(?P=mark)"'
    r'|"(?P<string>(?:[^"\\\n]|\\.)*)"'
    r"|(?<!\w)'(?:[^'\\\n]|\\.)+'"
    r"|//(?P<line>[^\n]*)"
    r"|/\*(?P<block>.*?)\*/",
    re.DOTALL,
)
PYTHON_TOKEN = re.compile(
    r'"""(?P<raw>.*?)"""' r'|"(?P<string>(?:[^"\\\n]|\\.)*)"' r"|'(?P<quoted>(?:[^'\\\n]|\\.)*)'" r"|#(?P<line>[^\n]*)",
    re.DOTALL,
)
# Single-quoted strings are skipped, because here-documents contain apostrophes.
SHELL_TOKEN = re.compile(r'(?:^|(?<=\s))#(?P<line>[^\n]*)|"(?P<string>(?:[^"\\\n]|\\.)*)"', re.MULTILINE)


def paragraphs_of_code(text, token):
    """Comments and strings, as (line number, text). Comments in adjacent lines are one paragraph."""
    paragraphs = []
    previous_end = None  # of the last comment that ends with its line
    for match in token.finditer(text):
        kind = match.lastgroup
        if kind is None or match.group(kind) is None:
            continue
        content = match.group(kind)
        if kind == "block":
            content = re.sub(r"(?m)^[ \t]*\*+", "", content)
        if kind in ("line", "block"):
            content = re.sub(r"^[!/*<]*[ \t]*", "", content)  # the markers of Doxygen
        if kind == "line":
            between = text[previous_end : match.start()] if previous_end is not None else None
            if between is not None and between.count("\n") == 1 and not between.strip() and content.strip():
                paragraphs[-1][1] += "\n" + content.strip()
            else:
                paragraphs.append([text.count("\n", 0, match.start()) + 1, content.strip()])
            previous_end = match.end()
        else:
            number = text.count("\n", 0, match.start(kind)) + 1
            for part in re.split(r"(\n\s*\n)", content):
                paragraphs.append([number, part])
                number += part.count("\n")
            previous_end = None
    return paragraphs


def paragraphs_of_page(text):
    """Prose of Markdown without code, as (line number, text)."""
    code = False
    lines = []
    for line in text.splitlines():
        if re.match(r"\s*```", line):
            code = not code
            line = ""
        is_code = code or line.startswith("    ")
        lines.append("" if is_code else re.sub(r"`[^`]*`", "`code`", line))
    paragraphs, number = [], 1
    for part in re.split(r"(\n(?:\s*\n)+|\n(?=[|#*-]))", "\n".join(lines)):
        paragraphs.append([number, part])
        number += part.count("\n")
    return paragraphs


def paragraphs_of(path):
    name = str(path)
    if name.endswith(C_LIKE):
        return paragraphs_of_code(read(path), C_TOKEN)
    if path.suffix == ".py":
        return paragraphs_of_code(read(path), PYTHON_TOKEN)
    if name.endswith(HASH_LIKE):
        return paragraphs_of_code(read(path), SHELL_TOKEN)
    return paragraphs_of_page(read(path)) if path.suffix == ".md" else []


def read_dialect():
    """Pairs of a regular expression and of advice."""
    phrases = []
    for entry in entries_of("dialect.txt"):
        expression, _, advice = entry.rpartition(" -> ")
        phrases.append((re.compile(expression.replace(" ", r"\s+"), re.IGNORECASE), advice))
    return phrases


PHRASES = read_dialect()


def phrases_of_dialect(path):
    for number, text in paragraphs_of(path):
        for expression, advice in PHRASES:
            for match in expression.finditer(text):
                shown = " ".join(match.group().split())
                yield number + text.count("\n", 0, match.start()), f'"{shown}": write {advice}'


# --- spelling ---------------------------------------------------------------------------------

# Names in camelCase are not words. codespell ignores case, and reports them if two words are a misspelling of one.
CAMEL_CASE = r"\b[a-z]+[A-Z]\w*\b"


def misspellings(paths):
    command = ["codespell", "--ignore-words", HERE / "spelling.txt", "--ignore-regex", CAMEL_CASE, *paths]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return done.stdout.splitlines() + (done.stderr.splitlines() if done.returncode not in (0, 65) else [])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("check", choices=("lines", "dialect", "spelling"))
    options = parser.parse_args()
    paths = files()
    if paths is None:
        print("skipped: no git, or no git repository")
        return SKIPPED
    if options.check == "spelling":
        found = misspellings(paths)
    else:
        check = long_lines if options.check == "lines" else phrases_of_dialect
        found = [f"{path}:{number}: {text}" for path in paths for number, text in check(path)]
    print("\n".join([*found, f"{len(paths)} files, {len(found)} findings"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
