#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Tests that prose.py finds phrases and long lines in each kind of file, at the right line, and only in prose."""

import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
import prose  # noqa: E402

C = """#include <a.h>
int alike = 1'000; // a comment
/*! A sentence. Who
 *  calls this is unknown. */
const char* s = "no phrase", *t = "are alike"; // fine
// bytes
// a quad
const char* r = R"(nobody
)";
"""
PYTHON = '''"""Who calls."""
alike = "x"  # nobody
text = "of which"
'''
SHELL = """echo alike # nobody
cat <<EOF
it's fine
EOF
fail "bytes a quad"
"""
PAGE = """# Title

Text with `nobody` in code, but alike
in prose.

    nobody

```
nobody
```
Who does this? A question is fine.
"""


class Prose(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.root, prose.ROOT = prose.ROOT, self.folder

    def tearDown(self):
        prose.ROOT = self.root

    def found(self, name, text):
        """Pairs of a line and the phrase in it."""
        (self.folder / name).write_text(text)
        return [(line, message.split('"')[1]) for line, message in sorted(prose.phrases_of_dialect(Path(name)))]

    def test_c_and_glsl(self):
        for name in ("a.cpp", "a.h", "a.glsl"):
            self.assertEqual(
                self.found(name, C), [(3, ". Who"), (5, "alike"), (6, "bytes a quad"), (8, "nobody")], name
            )

    def test_python(self):
        self.assertEqual(self.found("a.py", PYTHON), [(1, "Who"), (2, "nobody"), (3, "of which")])

    def test_shell_and_cmake(self):
        for name in ("a.sh", "CMakeLists.txt"):
            self.assertEqual(self.found(name, SHELL), [(1, "nobody"), (5, "bytes a quad")], name)

    def test_markdown(self):
        self.assertEqual(self.found("a.md", PAGE), [(3, "alike")])

    def test_long_lines(self):
        long = "x" * 121
        for name, text, lines in (
            ("a.cpp", f"// {long[:117]}\n// {long[:118]}\n", [2]),
            ("a.md", f"{long}\n| {long} |\n[x](y) {long}\n", [1]),
            ("b.cpp", "// " + "\u00e4" * 117 + "\n", []),
        ):
            (self.folder / name).write_text(text, encoding="utf-8")
            self.assertEqual([line for line, _ in prose.long_lines(Path(name))], lines, name)


if __name__ == "__main__":
    unittest.main()
