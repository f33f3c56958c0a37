#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks properties of the manual pages of functions, by reading pages that scripts/packaging/man_pages.py writes for
a header with known declarations, and for the public headers.

    man_pages.py
"""

import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
SCRIPT = ROOT / "scripts/packaging/man_pages.py"
HEADERS = sorted([*(ROOT / "include/embree3").glob("*.h"), ROOT / "include/cbvh/cbvh.h"])

HEADER = """
/* The result of a call. */
enum CbvhError
{
  CBVH_OK = 0
};

/* A pair of numbers: both finite. */
struct CbvhPair
{
  float a, b; /* first, second */
};

/* Options of a visit. */
struct CbvhVisit
{
  size_t structSize CBVH_SIZE_OF(CbvhVisit); /* by the rule */
  int flags CBVH_ZERO;
};

/* Options of a search. Call cbvhInitSearch first. */
struct CbvhSearch
{
  size_t structSize CBVH_SIZE_OF(CbvhSearch);
  float radius;
};

/* Called for each pair. */
typedef int (*CbvhPairFunction)(void* userPtr, const struct CbvhPair* pair);

/* Visits all pairs.
 * primitive: v0, v1 are no arguments: this is prose.
 *
 * function: called once per pair.
 * u, v:     where.
 *
 * Returns CBVH_OK or an error.
 *
 * Errors: CBVH_ERROR_UNKNOWN for a NULL function. Thread safety: any thread. */
CBVH_API enum CbvhError cbvhVisit(float u, float v[2], CbvhPairFunction function, void* userPtr);
CBVH_API enum CbvhError cbvhVisitAgain(float u);

/* Visits with options. */
CBVH_API void cbvhVisitWith(const struct CbvhVisit* visit);

/* Searches with options. */
CBVH_API void cbvhSearch(const struct CbvhSearch* search);

/* Returns the number of pairs. */
CBVH_API unsigned int cbvhCount(void);

/* Joins pairs.
 *
 * first: a pair.
 *
 * Return the number of pairs. */
CBVH_API int cbvhJoin(const struct CbvhPair* first,
    const struct CbvhPair* second,
    int flags);
"""


def made(folder, *headers):
    subprocess.run([sys.executable, "-B", SCRIPT, "1.2.3", folder, *headers], check=True)
    return {page.name: page.read_text() for page in Path(folder).iterdir()}


def section(page, name):
    found = re.search(rf"^\.SH {name}\n(.*?)(?=^\.SH |\Z)", page, re.S | re.M)
    return found[1].replace("\\-", "-") if found else None


class KnownHeader(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        header = Path(self.folder.name) / "cbvh" / "known.h"
        header.parent.mkdir()
        header.write_text(HEADER)
        self.pages = made(Path(self.folder.name) / "man", header)
        self.visit = self.pages["cbvhVisit.3cbvh"]

    def test_only_arguments_are_listed_as_arguments(self):
        description = section(self.visit, "DESCRIPTION")
        self.assertEqual(re.findall(r'^\.IP "([^"]*)"', description, re.M), ["function", "u, v"])
        self.assertIn("primitive: v0, v1 are no arguments: this is prose.", description)

    def test_return_value_may_be_described_for_several_functions(self):
        self.assertIn("Return the number of pairs.", section(self.pages["cbvhJoin.3cbvh"], "RETURN VALUE"))

    def test_types_and_callbacks_have_their_comments(self):
        synopsis = section(self.visit, "SYNOPSIS")
        order = [
            "A pair of numbers",
            "struct CbvhPair\n{",
            "Called for each pair",
            "typedef int (*CbvhPairFunction)",
            "enum CbvhError cbvhVisit(",
        ]
        places = [synopsis.find(text) for text in order]
        self.assertEqual(places, sorted(places))
        self.assertGreaterEqual(min(places), 0)

    def test_error_type_has_one_page(self):
        self.assertNotIn("CBVH_OK = 0", self.visit)
        self.assertIn("CbvhError(3cbvh)", section(self.visit, "SEE ALSO"))
        self.assertIn("CBVH_OK = 0", section(self.pages["CbvhError.3cbvh"], "SYNOPSIS"))
        self.assertNotIn("CbvhError", section(self.pages["cbvhCount.3cbvh"], "SEE ALSO"))

    def test_results_errors_and_threads_have_their_sections(self):
        self.assertEqual(section(self.visit, "RETURN VALUE"), ".PP\nReturns CBVH_OK or an error.\n")
        self.assertEqual(section(self.visit, "ERRORS"), ".PP\nCBVH_ERROR_UNKNOWN for a NULL function.\n")
        self.assertEqual(section(self.visit, "NOTES"), ".PP\nThread safety: any thread.\n")
        self.assertIsNone(section(self.visit, "EXIT STATUS"))

    def test_structs_with_size_have_no_default_and_a_note(self):
        page = self.pages["cbvhVisitWith.3cbvh"]
        self.assertIn("  size_t structSize; /* by the rule */\n  int flags;\n", section(page, "SYNOPSIS"))
        notes = section(page, "NOTES")
        self.assertEqual(notes.count("structSize"), 2)
        self.assertIn("T s = {.structSize = sizeof(s)}", notes)
        self.assertNotIn("structSize", self.visit)

    def test_structs_with_an_init_function_have_no_note(self):
        page = self.pages["cbvhSearch.3cbvh"]
        self.assertIn("Call cbvhInitSearch first", section(page, "SYNOPSIS"))
        self.assertIsNone(section(page, "NOTES"))

    def test_functions_under_one_comment_share_a_page(self):
        self.assertEqual(self.pages["cbvhVisitAgain.3cbvh"], ".so man3/cbvhVisit.3cbvh\n")

    def test_pages_can_be_indexed(self):
        self.assertTrue(self.visit.startswith('.TH "cbvhVisit" "3cbvh" '))
        self.assertEqual(section(self.visit, "NAME"), "cbvhVisit, cbvhVisitAgain - visits all pairs\n")

    def test_declaration_of_several_lines_has_a_page(self):
        page = self.pages["cbvhJoin.3cbvh"]
        self.assertIn(
            "int cbvhJoin(\n  const struct CbvhPair* first,\n  const struct CbvhPair* second,\n" "  int flags\n);",
            section(page, "SYNOPSIS"),
        )
        self.assertIn('.IP "first" 4\na pair.', section(page, "DESCRIPTION"))

    def test_function_without_a_comment_is_an_error(self):
        header = Path(self.folder.name) / "cbvh" / "bare.h"
        header.write_text("CBVH_API int cbvhBare(void);\n")
        done = subprocess.run(
            [sys.executable, "-B", SCRIPT, "1", self.folder.name, header], capture_output=True, text=True
        )
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"\Aman_pages\.py: cbvhBare .*comment\n\Z")


class PublicHeaders(unittest.TestCase):
    def test_each_function_has_a_page(self):
        with tempfile.TemporaryDirectory() as folder:
            pages = {name.split(".")[0] for name in made(folder, *HEADERS)}
            for header in HEADERS:
                # Declarations extend to their semicolon or body and may have several lines.
                declarations = re.findall(r"^(?:RTC_API|RTC_FORCEINLINE|CBVH_API)\s[^;{]*", header.read_text(), re.M)
                for declaration in declarations:
                    self.assertIn(re.search(r"(\w+)\s*\(", declaration)[1], pages, header.name)

    def test_pages_name_the_version_that_introduced_the_functions(self):
        with tempfile.TemporaryDirectory() as folder:
            pages = made(folder, *HEADERS)
        history = {name.split(".")[0]: section(page, "HISTORY") for name, page in pages.items()}
        self.assertIn("Available since 0.9.0.", history["rtcSetGeometryCompression"])
        self.assertIn("Available since 1.0.0.", history["rtcNewSurfaceFromGeometry"])
        listed = re.search(r'frozenset\(\s*"""(.*?)"""', SCRIPT.read_text(), re.S)[1].split()
        self.assertEqual([name for name in listed if name not in history], [])
        for name, page in pages.items():
            if "\n.SH RETURN VALUE" in page or "\n.SH ERRORS" in page:
                self.assertIsNotNone(history[name.split(".")[0]], name)

    def test_references_lead_to_pages_and_pages_have_no_warnings(self):
        with tempfile.TemporaryDirectory() as folder:
            pages = made(folder, *HEADERS)
            self.assertGreater(len(pages), 70)
            for name, page in pages.items():
                for macro in ("SIZE_OF", "_ZERO", "RTC_DEFAULT"):
                    self.assertNotIn(macro, page, name)
                for other in re.findall(r"(\w+)\((3\w+)\)", page):
                    self.assertIn(".".join(other), pages, name)
                if not page.startswith(".so") and shutil.which("groff"):
                    done = subprocess.run(
                        ["groff", "-man", "-ww", "-z", Path(folder) / name], capture_output=True, text=True
                    )
                    self.assertEqual(done.stderr, "", name)

    def test_types_of_each_page_are_declared_once(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, page in made(folder, *HEADERS).items():
                if not page.startswith(".so"):
                    declared = re.findall(r"^(?:struct|enum) (?:CBVH_ALIGNED )?(\w+)$", section(page, "SYNOPSIS"), re.M)
                    self.assertEqual(len(declared), len(set(declared)), name)


if __name__ == "__main__":
    unittest.main()
