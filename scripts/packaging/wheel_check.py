#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks that a wheel fits its manylinux tag, as `auditwheel show` does, and that it clashes with no Embree.

    wheel_check.py WHEEL

Requires readelf and nm. The wheel must contain a module for each version of CPython in its name, and no others. Checks
of each program and library:

    - it needs only libraries of the wheel, and those that every system of the tag has;
    - it needs no newer versions of their symbols than these systems have;
    - it searches for libraries only in folders of the wheel, relative to its own;
    - the file names of libraries of the wheel contain a hash, so that no other library of a process has them;
    - it neither exports nor imports functions of Embree by their own names.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass, field
from pathlib import Path

# PEP 600 and auditwheel's policy: part of the C and C++ runtime of every system with this version of glibc.
SYSTEM_LIBRARIES = frozenset(
    "ld-linux-x86-64.so.2 ld-linux-aarch64.so.1 libc.so.6 libdl.so.2 libgcc_s.so.1 libm.so.6 libpthread.so.0 "
    "librt.so.1 libstdc++.so.6".split()
)
# Newest version of the symbols on systems with a version of glibc. GCC 12 is the compiler of Debian 12.
NEWEST = {"2_36": {"GLIBC": (2, 36), "GLIBCXX": (3, 4, 30), "CXXABI": (1, 3, 13), "GCC": (12, 0, 0)}}
HASHED = re.compile(r"-[0-9a-f]{8}\.so")
MODULE = re.compile(r"embree_cbvh/__init__\.cpython-(\d+)-[\w-]+\.so")


@dataclass
class Binary:
    """Entries of the dynamic section of an ELF file."""

    name: str = ""  # its soname; empty for programs
    needed: list = field(default_factory=list)
    search: list = field(default_factory=list)
    versions: list = field(default_factory=list)  # "GLIBC_2.34"


def is_binary(path):
    with open(path, "rb") as file:
        return file.read(4) == b"\x7fELF"


def binaries_in(folder):
    return sorted(path for path in Path(folder).rglob("*") if path.is_file() and is_binary(path))


def output_of(*command):
    env = dict(os.environ, LC_ALL="C")
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, encoding="utf-8", env=env).stdout


def read_binary(path):
    binary = Binary()
    for tag, value in re.findall(r"\((NEEDED|SONAME|RPATH|RUNPATH)\)[^\[]*\[(.*)\]", output_of("readelf", "-dW", path)):
        if tag == "NEEDED":
            binary.needed.append(value)
        elif tag == "SONAME":
            binary.name = value
        else:
            binary.search += value.split(":")
    needs = output_of("readelf", "-VW", path).partition("Version needs section")[2]
    binary.versions = sorted(set(re.findall(r"Name: (\S+)", needs)))
    return binary


def embree_functions(path):
    """Names of dynamic symbols, defined or not, that stock Embree also has."""
    symbols = (line.split()[-1].partition("@")[0] for line in output_of("nm", "-D", path).splitlines())
    return sorted(name for name in symbols if name.startswith("rtc"))


def version_problems(versions, newest):
    problems = []
    for version in versions:
        family, _, number = version.partition("_")
        if re.fullmatch(r"[0-9.]+", number) and family in newest:
            if tuple(map(int, number.split("."))) > newest[family]:
                problems.append(f"needs {version}: expected at most {'.'.join(map(str, newest[family]))}")
    return problems


def problems_of(folder, interpreters, newest):
    """Returns a list of (file, problem) of the unpacked wheel in `folder`, and its number of programs and libraries.

    interpreters: the versions of CPython in the wheel's name, such as ["cp311", "cp313", "cp314"]
    newest: the newest versions of symbols of its systems, see NEWEST
    """
    folder = Path(folder).resolve()
    paths = binaries_in(folder)
    binaries = {path: read_binary(path) for path in paths}
    problems = []
    matches = (MODULE.fullmatch(path.relative_to(folder).as_posix()) for path in paths)
    modules = [f"cp{match[1]}" for match in matches if match]
    if sorted(modules) != sorted(interpreters):
        found = ", ".join(modules) or "no interpreter"
        problems.append((folder / "embree_cbvh", f"has modules for {found}: expected {', '.join(interpreters)}"))
    for path, binary in binaries.items():
        found = set()
        for place in binary.search:
            resolved = Path(place.replace("$ORIGIN", str(path.parent))).resolve()
            if not place.startswith("$ORIGIN") or folder not in resolved.parents:
                problems.append((path, f"searches in {place}: expected a folder of the wheel relative to $ORIGIN"))
            elif resolved.is_dir():
                found |= {entry.name for entry in resolved.iterdir()}
        for name in binary.needed:
            if name not in found and name not in SYSTEM_LIBRARIES:
                problems.append((path, f"needs {name}: expected a library of the wheel or of every system"))
        if binary.name and (binary.name != path.name or not HASHED.search(binary.name)):
            problems.append((path, f"has the soname {binary.name}: expected its file name, with a hash"))
        problems += [(path, text) for text in version_problems(binary.versions, newest)]
        functions = embree_functions(path)
        if functions:
            problems.append((path, f"has functions of Embree by their own names, such as {functions[0]}"))
    return [(path.relative_to(folder), text) for path, text in problems], len(paths)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", help="file of the wheel")
    wheel = Path(parser.parse_args().wheel)
    tag = re.search(r"-([\w.]+)-\1-manylinux_(\d+_\d+)_\w+\.whl$", wheel.name)
    if not tag or tag[2] not in NEWEST:
        sys.exit(f"{wheel}: no supported tag: expected manylinux_{' or manylinux_'.join(NEWEST)}")
    with tempfile.TemporaryDirectory() as folder:
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(folder)
        problems, count = problems_of(folder, tag[1].split("."), NEWEST[tag[2]])
    for path, text in problems:
        print(f"{path}: {text}", file=sys.stderr)
    if count == 0:
        sys.exit(f"{wheel}: contains no libraries")
    if problems:
        sys.exit(f"{wheel} does not fit its tag: {len(problems)} problems")
    print(f"{wheel.name}: {count} programs and libraries fit manylinux_{tag[2]}")


if __name__ == "__main__":
    main()
