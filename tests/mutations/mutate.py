#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Breaks the functions of a list on purpose, one token at a time, and runs the tests that must detect it.

    tests/mutations/mutate.py                              runs the entire list
    tests/mutations/mutate.py --minutes 20                 starts no further mutants after 20 minutes
    tests/mutations/mutate.py --only cellWeight CageTopology::
    tests/mutations/mutate.py --list                       lists the mutants
    tests/mutations/mutate.py --check build/dev            checks that the functions and tests of the list exist

The list (functions.py) names functions and tests; scanner.py finds the mutants of a function. The checkout does not
change: the tree is copied to BUILD/source and configured there as `dev`. In the copy, each function contains the
bodies of all its mutants, and an environment variable selects one of them, so that all are built at once. Without a
mutant all tests must pass.

A mutant is caught if one of its tests fails, and lives otherwise; the list explains mutants that no test can detect.
Mutants that do not compile count as neither. The exit status is 0 if all mutants were run and those that live are
explained, 1 if one survived or --check finds a fault, 2 after an error, and 3 if time ran out.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
KERNELS = ("kernels/cvert", "kernels/cbvh")
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE))
import scanner  # noqa: E402
from functions import FUNCTIONS  # noqa: E402

# a test hangs if it runs this many times as long as without a mutant, and at least SHORTEST_LIMIT seconds
PATIENCE = 5
SHORTEST_LIMIT = 20
SOUND_LIMIT = 600
SKIPPED = 77  # the exit status of a program for a different ISA


class Failure(Exception):
    """An error with a message of one line for the user."""


def read_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n")[0],
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=__doc__.split("\n", 2)[2],
    )
    parser.add_argument(
        "--build", metavar="DIR", default=str(ROOT / "build/mutations"), help="folder of the copy and of its build"
    )
    parser.add_argument("--list", action="store_true", help="list the mutants, and exit")
    parser.add_argument(
        "--check", metavar="DIR", help="check the list against the code and the tests built in DIR, and exit"
    )
    parser.add_argument("--only", nargs="+", metavar="NAME", default=[], help="mutants whose name has NAME in it")
    parser.add_argument(
        "--minutes", type=float, metavar="N", default=float("inf"), help="start no mutant after this time"
    )
    parser.add_argument(
        "--jobs", type=int, metavar="N", default=os.cpu_count(), help="number of processes (default: number of cores)"
    )
    parser.add_argument("--json", metavar="FILE", help="write the results")
    return parser.parse_args()


# --- the list and the code ----------------------------------------------------------------


def read_kernels():
    """Returns functions and text of every file: [(file, text, [Function])]."""
    files = sorted(p for kernels in KERNELS for p in (ROOT / kernels).rglob("*") if p.suffix in (".h", ".cpp"))
    texts = [(str(path.relative_to(ROOT)), path.read_text(encoding="utf-8")) for path in files]
    return [(file, text, scanner.functions_of(text)) for file, text in texts]


def find(name, kernels):
    """Returns the only file that defines a function, its text and the definitions."""
    found = [(file, text, [f for f in functions if f.is_called(name)]) for file, text, functions in kernels]
    found = [entry for entry in found if entry[2]]
    if len(found) != 1:
        raise Failure(f"{name} is in {' and in '.join(file for file, _, _ in found) or 'no file'}")
    return found[0]


def spread(items, most):
    """Returns at most this many items, evenly spaced."""
    return items if len(items) <= most else [items[int((i + 0.5) * len(items) / most)] for i in range(most)]


@dataclass
class Try:
    """A mutant and its result."""

    number: int
    file: str
    function: scanner.Function
    mutant: scanner.Mutant
    tests: tuple
    why: str  # reason why it lives, or None
    verdict: str = "not run"
    results: dict = field(default_factory=dict)  # result of each test


def tries_of(kernels, options):
    """Returns the mutants of the entire list."""
    tries = []
    for entry in FUNCTIONS:
        file, text, definitions = find(entry.name, kernels)
        mutants = [(f, m) for f in definitions for m in scanner.mutants_of(f, text)]
        for function, mutant in spread(mutants, entry.most):
            why = next((why for part, why in entry.explained.items() if part in mutant.name), None)
            tries.append(Try(len(tries) + 1, file, function, mutant, entry.tests, why))
    return [t for t in tries if not options.only or any(name in t.mutant.name for name in options.only)]


def split(test):
    """Splits 'unit Suite.Name:Suite.Other' into the unit and the GoogleTest filter."""
    unit, _, patterns = test.partition(" ")
    return unit, patterns or "*"


def program_of(directory, unit):
    return next(iter(sorted(Path(directory).glob(f"tests/*/test_{unit}"))), None)


def is_left_out(directory, unit):
    """True if the unit is for an instruction set that the build does not test."""
    cache = (Path(directory) / "CMakeCache.txt").read_text(encoding="utf-8")
    base = re.sub("_(sse2|sse42|avx|avx2|avx512)$", "", unit)
    return (
        "CBVH_THOROUGH_TESTS:BOOL=OFF" in cache
        and base != unit
        and any(Path(directory).glob(f"tests/isa/test_{base}_*"))
    )


def check(directory):
    """Checks the list against the code and against the programs in a build directory."""
    faults, kernels = [], read_kernels()
    for entry in FUNCTIONS:
        try:
            find(entry.name, kernels)
        except Failure as error:
            faults.append(str(error))
    for test in dict.fromkeys(test for entry in FUNCTIONS for test in entry.tests):
        unit, patterns = split(test)
        program = program_of(directory, unit)
        if not program and is_left_out(directory, unit):
            continue
        if not program:
            faults.append(f"{unit}: no such program in {directory}")
            continue
        answer = subprocess.run(
            [program, "--gtest_list_tests", f"--gtest_filter={patterns}"], capture_output=True, text=True
        )
        if answer.returncode != SKIPPED and not any(line.startswith("  ") for line in answer.stdout.splitlines()):
            faults.append(f"{unit}: no test is called {patterns}")
    print("\n".join((*faults, f"{len(FUNCTIONS)} functions, {len(faults)} faults of the list")))
    return 1 if faults else 0


# --- the copy -----------------------------------------------------------------------------


class Copy:
    """A copy of the tree next to the checkout that can be modified, and its build."""

    def __init__(self, directory, jobs):
        self.source = Path(directory).resolve() / "source"
        self.binary = self.source / "build/dev"
        self.log = Path(directory).resolve() / "build.log"
        self.jobs = jobs
        # lets ccache ignore the path of files
        self.environment = dict(os.environ, CCACHE_NOHASHDIR="1")

    def update(self, mutated):
        """Copies modified files, except for files that build_all writes, so that little is rebuilt."""
        mine = {path.relative_to(ROOT) for path in tree(ROOT)}
        for path in tree(self.source):
            if path.relative_to(self.source) not in mine:
                path.unlink()
        for name in mine:
            target = self.source / name
            if not target.is_file() or str(name) not in mutated and target.read_bytes() != (ROOT / name).read_bytes():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / name, target)

    def configure(self):
        command = [
            "cmake",
            "--preset",
            "dev",
            f"-DEMBREE_UPSTREAM_CACHE={ROOT / '.upstream'}",
            "-DCBVH_EMBREE_TUTORIALS=OFF",
        ]
        command += ["-DEMBREE_GEOMETRY_CURVE=OFF", "-DEMBREE_GEOMETRY_POINT=OFF"]
        if "EMBREE_UPSTREAM_ARCHIVE" in os.environ:
            command.append(f"-DEMBREE_UPSTREAM_ARCHIVE={os.environ['EMBREE_UPSTREAM_ARCHIVE']}")
        if self.call(command):
            raise Failure(f"the copy cannot be configured, see {self.log}")

    def build(self, units):
        """Returns the log if the build fails, otherwise ""."""
        targets = [f"test_{unit}" for unit in units]
        return self.call(
            ["cmake", "--build", self.binary, "-j", str(self.jobs), "--target", *targets, "--", "-k", "0"]
        )

    def call(self, command):
        with open(self.log, "w", encoding="utf-8") as log:
            code = subprocess.run(
                command, cwd=self.source, env=self.environment, stdout=log, stderr=subprocess.STDOUT
            ).returncode
        return self.log.read_text(encoding="utf-8") if code else ""

    def run(self, test, limit, mutant=0):
        """Returns the result of a test with a mutant, 'passes' or how it fails, and its duration in seconds."""
        unit, patterns = split(test)
        command = [program_of(self.binary, unit), f"--gtest_filter={patterns}", "--gtest_fail_fast", "--gtest_brief=1"]
        environment = dict(os.environ, CBVH_MUTANT=str(mutant))
        start = time.monotonic()
        try:
            code = subprocess.run(
                command,
                cwd=self.binary,
                env=environment,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                timeout=limit,
            ).returncode
            ended = "passes" if code in (0, SKIPPED) else "fails" if code > 0 else f"signal {-code}"
        except subprocess.TimeoutExpired:
            ended = "hangs"
        return ended, time.monotonic() - start


def tree(root):
    """Returns all files of a tree except for build products."""
    for directory, folders, files in os.walk(root):
        unwanted = ("build", "output", ".git", ".upstream") if Path(directory) == Path(root) else ("__pycache__",)
        folders[:] = [f for f in folders if f not in unwanted]
        yield from (Path(directory) / f for f in files if f != ".git")


# --- the run ------------------------------------------------------------------------------


def build_all(copy, tries, kernels):
    """Builds the test programs with all mutants that compile."""
    units = list(dict.fromkeys(split(test)[0] for t in tries for test in t.tests))
    left = tries
    while True:
        numbers = {}
        for file, text, _ in kernels:
            functions = {}
            for t in left:
                if t.file == file:
                    functions.setdefault(t.function, {})[t.number] = t.mutant
            text = scanner.with_mutants(text, list(functions.items())) if functions else text
            numbers[file] = scanner.numbers_of_lines(text)
            path = copy.source / file
            if path.read_text(encoding="utf-8") != text:
                path.write_text(text, encoding="utf-8")
        log = copy.build(units)
        if not log:
            return left
        # paths refer to the file itself or to a link in the build
        named = re.findall(r"(kernels/c(?:vert|bvh)/[\w/.]+):(\d+):\d+: (?:fatal )?error:", log)
        bad = {numbers[os.path.normpath(file)].get(int(line)) for file, line in named} - {None}
        if not bad:
            raise Failure(f"the tests cannot be built, see {copy.log}")
        for t in left:
            if t.number in bad:
                t.verdict = "does not compile"
        left = [t for t in left if t.number not in bad]


def try_mutant(copy, t, seconds_of, end):
    """Runs the tests of a mutant until one fails."""
    if t.verdict == "does not compile" or time.monotonic() > end:
        return t
    t.verdict = "lives" if t.why else "SURVIVED"
    for test in t.tests:
        t.results[test] = copy.run(test, max(SHORTEST_LIMIT, PATIENCE * seconds_of[test]), t.number)[0]
        if t.results[test] != "passes":
            t.verdict = "caught, against its explanation" if t.why else "caught"
            break
    return t


def show(t):
    seen = t.why or "; ".join(f"{test} {ended}" for test, ended in t.results.items())
    print(
        "| " + " | ".join(cell.replace("|", "\\|") for cell in (t.file, t.mutant.name, seen, t.verdict)) + " |",
        flush=True,
    )


def run(options):
    start = time.monotonic()
    kernels = read_kernels()
    tries = tries_of(kernels, options)
    if options.list:
        for t in tries:
            print(f"{t.file}: {t.mutant.name}" + (f"\n    lives: {t.why}" if t.why else ""))
        print(f"{len(tries)} mutants of {len({(t.file, t.function) for t in tries})} functions")
        return 0

    copy = Copy(options.build, options.jobs)
    copy.update({file for file, _, _ in kernels})
    copy.configure()
    seconds_of = {}
    for test in dict.fromkeys(test for t in build_all(copy, tries, kernels) for test in t.tests):
        ended, seconds_of[test] = copy.run(test, SOUND_LIMIT)
        if ended != "passes":
            raise Failure(f"without any mutant {test} {ended}")
    print(
        f"{len(tries)} mutants, {len(seconds_of)} tests\n\n| file | mutant | tests | verdict |\n|---|---|---|---|",
        flush=True,
    )
    with ThreadPoolExecutor(options.jobs) as pool:
        for t in pool.map(lambda t: try_mutant(copy, t, seconds_of, start + 60 * options.minutes), tries):
            show(t)
    if options.json:
        Path(options.json).write_text(
            json.dumps(
                [{"file": t.file, "mutant": t.mutant.name, "verdict": t.verdict, "tests": t.results} for t in tries],
                indent=1,
            ),
            encoding="utf-8",
        )
    verdicts = [t.verdict for t in tries]
    print(
        "\n"
        + ", ".join(f"{verdicts.count(v)} {v}" for v in dict.fromkeys(verdicts))
        + f"; {(time.monotonic() - start) / 60:.0f} minutes"
    )
    return 1 if "SURVIVED" in verdicts else 3 if "not run" in verdicts else 0


def main():
    try:
        options = read_arguments()
        return check(options.check) if options.check else run(options)
    except Failure as error:
        print(f"mutate.py: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
