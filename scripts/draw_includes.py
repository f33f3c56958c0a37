#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Draws the includes between rooms of folders, and writes the picture and their table into docs/architecture.md.

    scripts/draw_includes.py            writes both between the page's two markers
    scripts/draw_includes.py --check    exits with 1 if the page has a different picture

An arrow means "includes". Arrows that follow from others are left out to keep the diagram readable.
"""

import argparse
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/architecture.md"
BEGIN, END = "<!-- begin: scripts/draw_includes.py -->", "<!-- end -->"

# Boxes of the picture, from applications down: a purpose, and the folders, each with its own purpose.
ROOMS = {
    "programs": {
        "tutorials": "programs, Python module, examples",
        "common": "cages, maps, cameras, ray sets, metrics, images",
    },
    "public headers": {"include": "of libembree3, its Vulkan part, and libembree_cbvh"},
    "other libraries": {
        "kernels/capi": "functions of cbvh.h, of both libraries",
        "kernels/interposer": "geometry of Embree 4 programs",
        "kernels/vulkan": "libembree3_vulkan.so and shaders",
    },
    "calls": {
        "kernels/cbvh/api": "rtc functions, and where Embree calls us",
        "kernels/cbvh/operations": "each capability once, for all interfaces",
    },
    "building": {"kernels/cbvh/building": "sources, blocks, trees"},
    "traversal": {"kernels/cbvh/traversal": "rays, packets and point queries through the tree"},
    "surfaces": {
        "kernels/cbvh/files": "saved and mapped surfaces",
        "kernels/cbvh/backend": "a committed scene for back ends",
        "kernels/cbvh/blocks": "the blocks of a geometry, triangles and clusters out",
    },
    "representations": {
        "kernels/cbvh/exact": "cVERT: writer, SIMD decoders, intersectors",
        "kernels/cbvh/paper": "cGRID, cVOXEL, cLEAF",
    },
    "foundation": {
        "kernels/cbvh/surface": "vertices, patches, lattices, shared borders",
        "kernels/cbvh/base": "memory, IDs, statistics, Embree's vectors",
        "kernels/cbvh/settings": "what a geometry and a device keep",
        "kernels/cbvh/embree": "all includes of Embree's internals",
    },
    "codec": {
        "kernels/cvert/clusters": "clusters for GPUs",
        "kernels/cvert/file": "files: layout, reader, writer",
        "kernels/cvert/conversion": "blocks as tiles and back",
        "kernels/cvert/encoder": "lattice, encoder",
        "kernels/cvert/decoder": "validator, scalar decoder",
        "kernels/cvert/rule": "when a ray hits a triangle",
        "kernels/cvert/format": "blocks, cells, motion, numbers",
        "kernels/cvert/portable": "language, lanes, errors",
    },
}
ROOM_OF = {folder: room for room, folders in ROOMS.items() for folder in folders}


def folder_of(path):
    """Returns the folder of ROOM_OF that contains a path, or None. The path is relative to the repository."""
    inside = [folder for folder in ROOM_OF if path.startswith(folder + "/")]
    return max(inside, key=len, default=None)


def target_of(file, include):
    """Returns the path of an included file, relative to the repository, or None if the file is not part of the
    repository."""
    folders = (file.parent, ROOT, ROOT / "include", ROOT / "common", ROOT / "kernels", ROOT / "kernels/vulkan")
    for folder in folders:
        path = (folder / include).resolve()
        if path.is_file() and path.is_relative_to(ROOT):
            return str(path.relative_to(ROOT))
    # The patched tree links include/embree3 and kernels/cbvh into Embree's own folders.
    name = re.sub(r"^(\.\./)+", "", include)
    for prefix in ("", "include/", "kernels/"):
        if (ROOT / (prefix + name)).is_file():
            return prefix + name
    return None


def arrows():
    """Returns pairs of different rooms where a file of the first includes a header of the second."""
    found = set()
    for folder in ROOM_OF:
        for file in sorted((ROOT / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp", ".glsl", ".comp"):
                continue
            source = folder_of(str(file.relative_to(ROOT)))
            for include in re.findall(r'^\s*#include [<"]([^>"]+)[>"]', file.read_text(), re.MULTILINE):
                target = target_of(file, include)
                other = folder_of(target) if target else None
                if other and ROOM_OF[other] != ROOM_OF[source]:
                    found.add((ROOM_OF[source], ROOM_OF[other]))
    return found


def has_path(graph, start, end):
    """True if a path of arrows leads from start to end."""
    pending, visited = [start], set()
    while pending:
        room = pending.pop()
        for source, target in graph:
            if source == room and target not in visited:
                if target == end:
                    return True
                visited.add(target)
                pending.append(target)
    return False


def transitive_reduction(graph):
    """Removes arrows that follow from others."""
    return {arrow for arrow in graph if not has_path(graph - {arrow}, *arrow)}


def diagram():
    """Returns the diagram as a Mermaid flowchart, and the table of the folders."""
    names = {room: re.sub(r"\W", "_", room) for room in ROOMS}
    common_part = re.compile(r"^kernels/(cbvh/|cvert/)?")
    lines = ["```mermaid", "flowchart TD"]
    for room, folders in ROOMS.items():
        short = ", ".join(common_part.sub("", folder) for folder in folders)
        lines.append(f'  {names[room]}["<b>{room}</b><br>{short}"]')
    order, found = list(ROOMS), arrows()
    for source, target in found:
        if has_path(found, target, source):
            sys.exit(f"draw_includes.py: {source} and {target} include each other")
    drawn = sorted(transitive_reduction(found), key=lambda arrow: tuple(map(order.index, arrow)))
    lines += [f"  {names[source]} --> {names[target]}" for source, target in drawn]
    lines += ["```", "", "| room | folder | contains |", "|---|---|---|"]
    for room, folders in ROOMS.items():
        lines += [f"| {room} | `{folder}` | {purpose} |" for folder, purpose in folders.items()]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="only compare the page with the code")
    options = parser.parse_args()
    page = PAGE.read_text()
    before, rest = page.split(BEGIN)
    after = rest.split(END, 1)[1]
    drawn = f"{before}{BEGIN}\n\n{diagram()}\n\n{END}{after}"
    if not options.check:
        PAGE.write_text(drawn)
    elif drawn != page:
        sys.exit(
            f"{PAGE.relative_to(ROOT)}: the diagram differs from the includes of the code, run scripts/draw_includes.py"
        )


if __name__ == "__main__":
    main()
