#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks that a new type of blocks cannot be forgotten: adds one to a copy of the kernels, and expects that exactly the
sources that docs/architecture.md lists do not compile. Also checks that each type of references to blocks occurs in the
shaders, which compilers do not check.

    block_types.py KERNELS COMPILE_COMMANDS

Takes the commands of the build from compile_commands.json and checks syntax only.
"""

import json
import os
import pathlib
import re
import shutil
import sys
import tempfile

from compile_commands import syntax_check

NUMBER = "8"  # of no type, see cvert/format/block_type.h
HEADER = "cvert/format/block_type.h"
# Switches over BlockType, by source: the file and the number of its functions that differ by type.
PLACES = {
    "cvert/file/file.cpp": {"cvert/file/record.h": 2},
    "cbvh/backend/flat_scene.cpp": {"cbvh/blocks/block_table.h": 1},
    "cbvh/blocks/stored_triangles.cpp": {"cbvh/blocks/stored_triangles.cpp": 6, "cbvh/blocks/block_table.h": 1},
    "cbvh/building/builder.cpp": {"cbvh/building/moving_blocks.h": 1, "cbvh/blocks/block_table.h": 1},
    "cbvh/traversal/intersector1.cpp": {"cbvh/traversal/intersector1.cpp": 3},
    "cbvh/traversal/moving_intersector1.cpp": {"cbvh/traversal/moving_intersector1.cpp": 1},
    "cbvh/traversal/intersectorK.cpp": {"cbvh/traversal/intersectorK.cpp": 1},
    "cbvh/traversal/point_query.cpp": {"cbvh/traversal/point_query.cpp": 1},
    "vulkan/host/blocks.cpp": {"vulkan/host/blocks.cpp": 1},
}


def copy_with_new_type(upstream, kernels, folder):
    """Copies Embree's and our kernels, with a further type of blocks, so that relative includes find the copies."""
    for name in ("common", "include"):
        os.symlink(upstream / name, folder / name)
    shutil.copytree(upstream / "kernels", folder / "kernels", ignore=shutil.ignore_patterns("cbvh", "cvert"))
    for name in ("cbvh", "cvert", "vulkan"):
        shutil.copytree(kernels / name, folder / "kernels" / name)
    header = folder / "kernels" / HEADER
    text = header.read_text(encoding="utf-8")
    changed = text.replace("enum BlockType : uint32_t {", f"enum BlockType : uint32_t {{\n  NEW_BLOCK = {NUMBER},")
    assert changed != text
    header.write_text(changed, encoding="utf-8")


def command_in_copy(entry, upstream, kernels, folder, source):
    """The entry's command, for the copy of its source."""
    command = entry["command"].replace(str(upstream), str(folder))
    command = command.replace(str(kernels) + "/", str(folder / "kernels") + "/")
    if source.startswith("vulkan/"):  # includes "kernels/..." from the folder above
        command += f" -I{folder}"
    return {"directory": entry["directory"], "command": command}


def forgotten(stderr):
    """The number of switches that do not handle the new type, by file."""
    places = {}
    lines = re.findall(r"^(\S+?):(\d+):\d+: error: .*\bNEW_BLOCK\b.*not handled", stderr, re.MULTILINE)
    for path, _ in {(os.path.normpath(path).split("/kernels/", 1)[1], line) for path, line in lines}:
        places[path] = places.get(path, 0) + 1
    return places


def main():
    kernels = pathlib.Path(sys.argv[1]).resolve()
    with open(sys.argv[2], encoding="utf-8") as file:
        commands = json.load(file)
    upstream = pathlib.Path(sys.argv[2]).resolve().parent / "upstream"
    failures = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name).resolve()
        copy_with_new_type(upstream, kernels, folder)
        for source, expected in PLACES.items():
            entry = next((e for e in commands if e["file"].endswith("/kernels/" + source)), None)
            if entry is None and source.startswith("vulkan/"):
                print(f"{source}: not part of this build")
                continue
            run = syntax_check(command_in_copy(entry, upstream, kernels, folder, source), "-Werror=switch")
            found = forgotten(run.stderr)
            print(f"{source}: {found}")
            if run.returncode == 0:
                failures.append(f"{source} compiles without the new type")
            elif found != expected:
                failures.append(f"{source}: {found}, expected {expected}:\n{run.stderr[:2000]}")
    page = (kernels.parent / "docs/architecture.md").read_text(encoding="utf-8")
    for path in {path for expected in PLACES.values() for path in expected}:
        if pathlib.PurePath(path).name not in page:
            failures.append(f"architecture.md does not list {path}")
    reference = (kernels / "cbvh/base/reference.h").read_text(encoding="utf-8")
    shader = (kernels / "vulkan/shaders/cbvh.glsl").read_text(encoding="utf-8")
    for constant in re.findall(r"uint32_t (\w+[bB]lockReferenceType) =", reference):
        if constant not in shader:
            failures.append(f"cbvh.glsl does not use {constant}")
    print("\n".join(failures))
    sys.exit(bool(failures))


main()
