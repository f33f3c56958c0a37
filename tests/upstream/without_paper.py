#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks that sources which choose by representation compile without the paper's representations
(EMBREE_CBVH_PAPER=OFF), and then include only headers for the layout of their blocks. Also checks that other folders
include only the entries of the paper's folder (paper/interface.h), and that rays through cVERT depend on few of our
files, none of them the paper's, with and without its representations.

    without_paper.py COMPILE_COMMANDS

Takes the commands of the build from compile_commands.json and checks syntax only.
"""

import json
import os
import re
import sys

from compile_commands import syntax_check

SOURCES = (
    "traversal/intersectorK.cpp",
    "traversal/mesh_intersector1.cpp",
    "traversal/thread_cache.cpp",
    "building/builder.cpp",
    "files/loaded_surface.cpp",
    "operations/compression.cpp",
    "api/settings.cpp",
)
# In paper/: headers that identify blocks with frames in files, and the entry of traversal.
LAYOUT = {"block.h", "morton.h", "interface.h"}
ENTRIES = {"block.h", "interface.h", "node_cache.h", "writer.h"}
RAY = "traversal/intersector1.cpp"  # a ray through cVERT blocks and tiles
MOTION = "traversal/moving_intersector1.cpp"
MOST_FILES_OF_A_RAY = 45
MOST_FILES_OF_MOTION = 14  # in addition, mesh blocks included


def files_of(commands, source, failures, *options):
    """A source and our files that it depends on."""
    entry = next(entry for entry in commands if entry["file"].endswith("/kernels/cbvh/" + source))
    run = syntax_check(entry, "-H", *options)
    if run.returncode != 0:
        errors = [line for line in run.stderr.splitlines() if not line.startswith((".", "/usr/"))]
        failures.append(f"{source} does not compile:\n" + "\n".join(errors[:20]))
    paths = map(os.path.normpath, re.findall(r"^\.+ (\S+)$", run.stderr, re.MULTILINE))
    matches = (re.search(r"/kernels/(c(?:bvh|vert)/.*)$", path) for path in paths)
    return {"cbvh/" + source} | {match.group(1) for match in matches if match}


def framed(files):
    return sorted(path for path in files if "/paper/" in path and path.rsplit("/", 1)[1] not in LAYOUT)


def check_rays(commands, failures, *options):
    ray = files_of(commands, RAY, failures, *options)
    motion = files_of(commands, MOTION, failures, *options) - ray
    for of, files, most in (("rays", ray, MOST_FILES_OF_A_RAY), ("motion", motion, MOST_FILES_OF_MOTION)):
        print(f"{of} {' '.join(options)}: {len(files)} files of ours")
        if len(files) > most or framed(files):
            names = " ".join(sorted(files))
            failures.append(f"{of} depend on {len(files)} files, at most {most} and none of the paper's:\n{names}")


def check_entries(kernels, failures):
    for folder, _, names in os.walk(kernels):
        if "/cbvh/paper" in folder:
            continue
        for name in names:
            if not name.endswith((".h", ".cpp")):
                continue
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                for entry in re.findall(r'#include ".*\bpaper/(\S+)"', file.read()):
                    if entry not in ENTRIES:
                        failures.append(f"{folder}/{name} includes paper/{entry}: not in paper/interface.h's table")


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        commands = json.load(file)
    failures = []
    check_entries(os.path.join(os.path.dirname(__file__), "../../kernels"), failures)
    check_rays(commands, failures)
    check_rays(commands, failures, "-DEMBREE_CBVH_NO_PAPER")
    for source in SOURCES:
        files = files_of(commands, source, failures, "-DEMBREE_CBVH_NO_PAPER")
        if framed(files):
            failures.append(f"{source} includes {', '.join(framed(files))}")
    print("\n".join(failures))
    sys.exit(bool(failures))


main()
