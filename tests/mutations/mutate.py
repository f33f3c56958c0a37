#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Breaks the code on purpose, one line at a time, and runs the tests that should notice.

    tests/mutations/mutate.py --build build/mutations              all of them: hours
    tests/mutations/mutate.py --only NAME... --jobs 4              some
    tests/mutations/mutate.py --list                               says what there is
    tests/mutations/mutate.py --check build/dev                    compares the list with the code, breaks nothing

Each mutation (list_codec.py and so on, by rooms of kernels/cbvh) is one edit of one file and
the tests that have to fail then, each of them. Nothing is changed here: the tree is
copied to BUILD/source, configured there as `dev`, and of its targets only those are built
that the tests need. First all tests have to pass without any mutation.

The exit status is 0 if every mutation was caught but for those that are declared harmless,
which nothing may catch.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE))
import list_api  # noqa: E402
import list_build  # noqa: E402
import list_codec  # noqa: E402
import list_trace  # noqa: E402
import list_vert  # noqa: E402
from mutation import PLANNED  # noqa: E402

MUTATIONS = list_codec.MUTATIONS + list_build.MUTATIONS + list_vert.MUTATIONS + list_trace.MUTATIONS + list_api.MUTATIONS

# rooms of tests; programs of the first two do not link the library: cheap to build, so first
HEADER_ONLY = ("codec", "isa")
ROOMS = (*HEADER_ONLY, "library", "hard_cases", "common")

# a mutated test that runs this much longer than the sound one hangs
PATIENCE = 5
SHORTEST_LIMIT = 60
SOUND_LIMIT = 1200


class Failure(Exception):
    """Its text is one line for the user."""


def read_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n")[0],
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=__doc__.split("\n", 2)[2],
    )
    parser.add_argument("--build", metavar="DIR", default=str(ROOT / "build/mutations"), help="folder of the copy and of its build")
    parser.add_argument("--list", action="store_true", help="list the mutations, and end")
    parser.add_argument("--check", metavar="DIR", help="check the list against the code and the tests built in DIR, and end")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these mutations, or those of which NAME is a part")
    parser.add_argument("--jobs", type=int, metavar="N", default=os.cpu_count(), help="processes at a time (default: one a core)")
    parser.add_argument("--json", metavar="FILE", help="write the results")
    return parser.parse_args()


def chosen(names):
    if not names:
        return list(MUTATIONS)
    for name in names:
        if not any(name in m.name for m in MUTATIONS):
            raise Failure(f"no mutation is called '{name}', see --list")
    exact = {m.name for m in MUTATIONS} & set(names)
    return [m for m in MUTATIONS if m.name in exact or any(n in m.name for n in names if n not in exact)]


def tests_of(mutations):
    """Names of all tests, each once, in order."""
    return list(dict.fromkeys(test for m in mutations for test in m.tests))


def split(test):
    """Unit and GoogleTest filter of 'unit Suite.Name:Suite.Other'."""
    unit, _, patterns = test.partition(" ")
    return unit, patterns or "*"


def room_of(unit):
    """The room of tests that has the program of a unit; None where there is none (yet)."""
    return next((room for room in ROOMS if has_unit(room, unit)), None)


def has_unit(room, unit):
    if room == "isa":
        return unit.startswith(("simd_decoding_", "simd_tracing_", "vert_decoding_"))
    return unit == room or (ROOT / "tests" / room / f"{unit}.cpp").exists()


def exists(test):
    return room_of(split(test)[0]) is not None


# --- the list against the code ------------------------------------------------------------


def occurrences(mutation):
    path = ROOT / mutation.file
    return path.read_text(encoding="utf-8").count(mutation.old) if path.is_file() else 0


def faults_of_list(mutations):
    """What is wrong with the list itself: lines for the user."""
    faults = []
    names = [m.name for m in mutations]
    for m in mutations:
        if names.count(m.name) > 1:
            faults.append(f"{m.name}: the name is not unique")
        if occurrences(m) != 1:
            faults.append(f"{m.name}: its text is {occurrences(m)} times in {m.file}, expected once")
        if m.old == m.new:
            faults.append(f"{m.name}: changes nothing")
        if not m.tests:
            faults.append(f"{m.name}: names no test")
        for unit in {split(test)[0] for test in m.tests if not exists(test)} - PLANNED:
            faults.append(f"{m.name}: there is no test program {unit}")
    return faults


def faults_of_tests(mutations, directory):
    """Tests that the programs in a build directory do not have."""
    faults = []
    for test in tests_of(mutations):
        unit, patterns = split(test)
        if not exists(test):
            continue
        program = program_of(directory, unit)
        if not program:
            faults.append(f"{unit}: no such program in {directory}")
            continue
        for pattern in patterns.split(":"):
            answer = subprocess.run([program, "--gtest_list_tests", f"--gtest_filter={pattern}"], capture_output=True, text=True)
            if not any(line.startswith("  ") for line in answer.stdout.splitlines()):
                faults.append(f"{unit}: no test is called {pattern}")
    return faults


def program_of(directory, unit):
    found = sorted(Path(directory).glob(f"tests/*/test_{unit}"))
    return found[0] if found else None


def check(directory):
    if not Path(directory, "CMakeCache.txt").is_file():
        raise Failure(f"{directory}: no build directory")
    faults = faults_of_list(MUTATIONS) + faults_of_tests(MUTATIONS, directory)
    for fault in faults:
        print(fault)
    planned = sorted({split(test)[0] for test in tests_of(MUTATIONS) if not exists(test)} & PLANNED)
    print(f"{len(MUTATIONS)} mutations, {len(faults)} faults of the list" + (f"; tests yet to be written: {', '.join(planned)}" if planned else ""))
    return 1 if faults else 0


# --- the copy -----------------------------------------------------------------------------


class Copy:
    """A tree beside the checkout, which may be broken, and its build."""

    def __init__(self, directory, jobs):
        self.source = Path(directory).resolve() / "source"
        self.binary = self.source / "build/dev"
        self.log = Path(directory).resolve() / "build.log"
        self.jobs = jobs
        # the hash of a file is that of its text, wherever it is built
        self.environment = dict(os.environ, CCACHE_NOHASHDIR="1")

    def update(self):
        """Copies what differs, so that little is built anew."""
        mine = {path.relative_to(ROOT) for path in tree(ROOT)}
        for path in tree(self.source):
            if path.relative_to(self.source) not in mine:
                path.unlink()
        for name in mine:
            target = self.source / name
            if target.is_symlink() or not target.is_file() or target.read_bytes() != (ROOT / name).read_bytes():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / name, target)

    def configure(self):
        command = ["cmake", "--preset", "dev", f"-DEMBREE_UPSTREAM_CACHE={ROOT / '.upstream'}", "-DCBVH_EMBREE_TUTORIALS=OFF"]
        archive = os.environ.get("EMBREE_UPSTREAM_ARCHIVE")
        if archive:
            command.append(f"-DEMBREE_UPSTREAM_ARCHIVE={archive}")
        if not self.call(command):
            raise Failure(f"the copy cannot be configured, see {self.log}")

    def build(self, units):
        return self.call(["cmake", "--build", self.binary, "-j", str(self.jobs), "--target", *(f"test_{unit}" for unit in units)])

    def call(self, command):
        with open(self.log, "w", encoding="utf-8") as log:
            return subprocess.run(command, cwd=self.source, env=self.environment, stdout=log, stderr=subprocess.STDOUT).returncode == 0

    def run(self, test, limit):
        """How a test ends: 'passes', or how it fails; and after how many seconds."""
        unit, patterns = split(test)
        command = [program_of(self.binary, unit), f"--gtest_filter={patterns}", "--gtest_fail_fast", "--gtest_brief=1"]
        start = time.monotonic()
        try:
            code = subprocess.run(command, cwd=self.binary, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=limit).returncode
            ended = "passes" if code == 0 else "fails" if code > 0 else f"signal {-code}"
        except subprocess.TimeoutExpired:
            ended = "hangs"
        return ended, time.monotonic() - start

    def run_all(self, tests, limit_of):
        with ThreadPoolExecutor(self.jobs) as pool:
            return dict(zip(tests, pool.map(lambda test: self.run(test, limit_of(test)), tests)))


def tree(root):
    """All files of a tree but of what is built."""
    for directory, folders, files in os.walk(root):
        if Path(directory) == Path(root):
            folders[:] = [f for f in folders if f not in ("build", "output", ".git", ".upstream")]
        folders[:] = [f for f in folders if f != "__pycache__"]
        yield from (Path(directory) / f for f in files if f != ".git")


# --- the run ------------------------------------------------------------------------------


def grouped(mutations):
    """Those whose tests are cheap first; then those of the same file and of the same programs in sequence."""

    def key(m):
        units = sorted({split(test)[0] for test in m.tests})
        return any(room_of(unit) not in HEADER_ONLY for unit in units), m.file, units

    return sorted(mutations, key=key)


def measure_sound(copy, tests):
    """Seconds of each test without a mutation: all have to pass."""
    units = sorted({split(test)[0] for test in tests})
    if not copy.build(units):
        raise Failure(f"the tests cannot be built, see {copy.log}")
    results = copy.run_all(tests, lambda test: SOUND_LIMIT)
    bad = [f"{test} {ended}" for test, (ended, _) in results.items() if ended != "passes"]
    if bad:
        raise Failure("without any mutation " + "; ".join(bad))
    return {test: seconds for test, (_, seconds) in results.items()}


def try_mutation(copy, mutation, seconds_of):
    """A record of what became of it."""
    path = copy.source / mutation.file
    sound = path.read_text(encoding="utf-8")
    tests = [test for test in mutation.tests if exists(test)]
    start = time.monotonic()
    results = {}
    try:
        path.write_text(sound.replace(mutation.old, mutation.new), encoding="utf-8")
        built = copy.build(sorted({split(test)[0] for test in tests}))
        if built:
            results = copy.run_all(tests, lambda test: max(SHORTEST_LIMIT, PATIENCE * seconds_of[test]))
    finally:
        path.write_text(sound, encoding="utf-8")
    missed = [test for test in tests if built and results[test][0] == "passes"]
    return {
        "name": mutation.name,
        "file": mutation.file,
        "breaks": mutation.breaks,
        "harmless": mutation.harmless,
        "verdict": judge(mutation, built, tests, missed),
        "tests": {test: results[test][0] if built else "not built" for test in tests},
        "planned": [test for test in mutation.tests if not exists(test)],
        "seconds": round(time.monotonic() - start, 1),
    }


def judge(mutation, built, tests, missed):
    if not built:
        return "does not compile"
    if mutation.harmless:
        return "harmless" if len(missed) == len(tests) else "caught, though declared harmless"
    if not tests:
        return "waits for its test"
    return "survived" if missed else "caught"


GOOD = ("caught", "harmless", "waits for its test")


def show(record):
    tests = [f"{test} {ended}" for test, ended in record["tests"].items()] + [f"{test} is planned" for test in record["planned"]]
    cells = (record["name"], record["file"].replace("kernels/cbvh/", ""), record["breaks"], "; ".join(tests), record["verdict"], f"{record['seconds']:.0f}")
    print("| " + " | ".join(cells) + " |", flush=True)


def run(options):
    mutations = grouped(chosen(options.only))
    if options.list:
        for m in mutations:
            print(f"{m.name}\n    {m.file}: {m.breaks}\n    {'; '.join(m.tests)}" + (f"\n    harmless: {m.harmless}" if m.harmless else ""))
        print(f"{len(mutations)} mutations")
        return 0
    faults = faults_of_list(mutations)
    if faults:
        raise Failure("; ".join(faults))

    copy = Copy(options.build, options.jobs)
    copy.update()
    copy.configure()
    tests = [test for test in tests_of(mutations) if exists(test)]
    print(f"{len(mutations)} mutations; first {len(tests)} tests without any", flush=True)
    seconds_of = measure_sound(copy, tests)
    print("\n| mutation | file | what breaks | tests that have to fail | verdict | seconds |\n|---|---|---|---|---|---:|", flush=True)
    records = []
    for mutation in mutations:
        records.append(try_mutation(copy, mutation, seconds_of))
        show(records[-1])
        if options.json:
            Path(options.json).write_text(json.dumps(records, indent=1) + "\n", encoding="utf-8")
    verdicts = [record["verdict"] for record in records]
    print("\n" + ", ".join(f"{verdicts.count(v)} {v}" for v in dict.fromkeys(verdicts)) + f"; {sum(r['seconds'] for r in records):.0f} s")
    return 0 if all(v in GOOD for v in verdicts) else 1


def main():
    options = read_arguments()
    try:
        return check(options.check) if options.check else run(options)
    except Failure as error:
        print(f"mutate.py: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
