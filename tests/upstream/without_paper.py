#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks that sources which choose by representation compile without the paper's representations
(EMBREE_CBVH_PAPER=OFF), and then include only headers for the layout of their blocks. Also checks that rays through
cVERT depend on few of our files.

    without_paper.py COMPILE_COMMANDS

Takes the commands of the build from compile_commands.json and checks syntax only.
"""

import json
import os
import re
import sys

from compile_commands import syntax_check

SOURCES = (
    "traversal/intersector1.cpp",
    "traversal/intersectorK.cpp",
    "traversal/thread_cache.cpp",
    "building/builder.cpp",
    "files/loaded_surface.cpp",
    "operations/compression.cpp",
    "api/settings.cpp",
)
LAYOUT = {"block.h", "morton.h"}  # in paper/: headers that identify blocks with frames in files
MOST_FILES_OF_A_RAY = 45  # static and moving grids of vertices
MOST_FILES_OF_MESH_BLOCKS = 6  # in addition
MOVING_MESHES = r"/(moving_mesh|mesh_motion|mesh_motion_decoder|mesh_step_view|mesh_view)\.h$"
MOST_FILES_OF_MOVING_MESH_BLOCKS = 5  # in addition to these


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        commands = json.load(file)
    failures = []
    for source in SOURCES:
        entry = next(entry for entry in commands if entry["file"].endswith("/kernels/cbvh/" + source))
        run = syntax_check(entry, "-H", "-DEMBREE_CBVH_NO_PAPER")
        if run.returncode != 0:
            errors = [line for line in run.stderr.splitlines() if not line.startswith((".", "/usr/"))]
            failures.append(f"{source} does not compile:\n" + "\n".join(errors[:20]))
        paths = map(os.path.normpath, re.findall(r"^\.+ (\S+)$", run.stderr, re.MULTILINE))
        ours = {
            match.group(1) for match in (re.search(r"/kernels/(c(?:bvh|vert)/.*)$", path) for path in paths) if match
        }
        framed = sorted(path for path in ours if "/paper/" in path and path.rsplit("/", 1)[1] not in LAYOUT)
        if framed:
            failures.append(f"{source} includes {', '.join(framed)}")
        print(f"{source}: {len(ours)} files of ours")
        if source != "traversal/intersector1.cpp":
            continue
        moving = {path for path in ours if re.search(MOVING_MESHES, path)}
        mesh = {path for path in ours - moving if re.search(r"/(mesh_\w+|cached_mesh)\.h$", path)}
        for of, files, most in (
            ("rays", ours - mesh - moving, MOST_FILES_OF_A_RAY),
            ("rays through mesh blocks", mesh, MOST_FILES_OF_MESH_BLOCKS),
            ("rays through moving mesh blocks", moving, MOST_FILES_OF_MOVING_MESH_BLOCKS),
        ):
            if len(files) > most:
                names = " ".join(sorted(files))
                failures.append(f"{source} includes {len(files)} files for {of}, at most {most}:\n{names}")
    print("\n".join(failures))
    sys.exit(bool(failures))


main()
