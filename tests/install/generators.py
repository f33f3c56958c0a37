#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Runs the generators of manual pages and completions once: each function of the public headers has a page that groff
accepts and whose references lead to pages, and bash completes options, words and files. The test install checks that
they are installed."""

import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HEADERS = sorted([*(ROOT / "include/embree3").glob("*.h"), ROOT / "include/cbvh/cbvh.h"])
HELP = """Options:
  -h,--help                   Print this help message and exit
  --up AXIS:{auto,x,-x}       axis that points upwards
  -o,--output FILE=a.png      picture to write
"""
COMPLETE = """compopt() { :; }
. "$1"
COMP_WORDS=(sample "${@:2}") COMP_CWORD=$(($# - 1))
_sample
echo "${COMPREPLY[*]}"
"""


def generate(script, *arguments):
    subprocess.run([sys.executable, "-B", ROOT / "scripts/packaging" / script, *arguments], check=True)


class Generators(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def test_manual_pages(self):
        generate("man_pages.py", "1.2.3", self.folder, *HEADERS)
        pages = {path.name: path.read_text() for path in self.folder.iterdir()}
        functions = {name.split(".")[0] for name in pages}
        for header in HEADERS:
            for declaration in re.findall(r"^(?:RTC_API|RTC_FORCEINLINE|CBVH_API)\s[^;{]*", header.read_text(), re.M):
                self.assertIn(re.search(r"(\w+)\s*\(", declaration)[1], functions, header.name)
        for name, page in pages.items():
            self.assertNotRegex(page, "SIZE_OF|_ZERO|RTC_DEFAULT", name)
            for other in re.findall(r"(\w+)\((3\w+)\)", page):
                self.assertTrue(".".join(other) in pages, f"{name} refers to {other}")
            if shutil.which("groff") and not page.startswith(".so"):
                groff = ["groff", "-man", "-ww", "-z", self.folder / name]
                self.assertEqual(subprocess.run(groff, capture_output=True, text=True).stderr, "", name)

    def test_completions(self):
        program = self.folder / "program.sh"
        program.write_text(f"cat << 'END'\n{HELP}END\n")
        generate("completions.py", self.folder / "sample", "sh", program)
        for words, expected in ((["--"], "-h --help --up -o --output"), (["--up", ""], "auto x -x"), (["-o", ""], "")):
            command = ["bash", "--norc", "-c", COMPLETE, "bash", self.folder / "sample", *words]
            found = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
            self.assertLessEqual(set(found), set(expected.split()))
            self.assertEqual(bool(found), bool(expected), words)


if __name__ == "__main__":
    unittest.main()
