#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Draws the includes between folders, and writes the diagram into docs/architecture.md.

    scripts/draw_includes.py            writes the Mermaid diagram between the page's two markers
    scripts/draw_includes.py --check    exits with 1 if the page has a different diagram

An arrow means "includes". Arrows that follow from others are left out to keep the diagram readable.
"""

import argparse
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/architecture.md"
BEGIN, END = "<!-- begin: scripts/draw_includes.py -->", "<!-- end -->"

# Folders and their purposes, from applications down. A file belongs to the longest matching folder.
FOLDERS = {
    "tutorials": "programs, Python module, examples",
    "common": "cages, maps, cameras, ray sets, metrics, images",
    "kernels/interposer": "subdivision geometry of Embree 4 programs",
    "kernels/capi": "functions of cbvh.h, of both libraries",
    "kernels/vulkan": "libembree3_vulkan.so and shaders",
    "include": "public headers",
    "kernels/cbvh/api": "rtc functions, and where Embree calls us",
    "kernels/cbvh/operations": "each capability once, for all interfaces",
    "kernels/cbvh/building": "sources, blocks, trees",
    "kernels/cbvh/traversal": "rays, packets and point queries through the tree",
    "kernels/cbvh/files": "saved and mapped surfaces",
    "kernels/cbvh/backend": "a committed scene for back ends",
    "kernels/cbvh/blocks": "the blocks of a geometry, triangles and clusters out",
    "kernels/cbvh/exact": "cVERT: writer, SIMD decoders, intersectors",
    "kernels/cbvh/paper": "cGRID, cVOXEL, cLEAF",
    "kernels/cbvh/surface": "vertices, patches, lattices, shared borders",
    "kernels/cbvh/settings": "what a geometry and a device keep",
    "kernels/cbvh/base": "memory, IDs, statistics, Embree's vectors",
    "kernels/cbvh/embree": "all includes of Embree's internals",
    "kernels/cvert/clusters": "clusters for GPUs",
    "kernels/cvert/file": "files: layout, reader, writer",
    "kernels/cvert/encoder": "lattice, encoder",
    "kernels/cvert/decoder": "validator, scalar decoder",
    "kernels/cvert/rule": "when a ray hits a triangle",
    "kernels/cvert/format": "blocks, cells, motion, numbers",
    "kernels/cvert/portable": "language, lanes, errors",
}


def folder_of(path):
    """Returns the longest of FOLDERS that contains a path, or None. The path is relative to the repository."""
    inside = [folder for folder in FOLDERS if path.startswith(folder + "/")]
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
    """Returns pairs of different folders where a file of the first includes a header of the second."""
    found = set()
    for folder in FOLDERS:
        for file in sorted((ROOT / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp", ".glsl", ".comp"):
                continue
            source = folder_of(str(file.relative_to(ROOT)))
            for include in re.findall(r'^\s*#include [<"]([^>"]+)[>"]', file.read_text(), re.MULTILINE):
                target = target_of(file, include)
                other = folder_of(target) if target else None
                if other and other != source:
                    found.add((source, other))
    return found


def has_path(graph, start, end):
    """True if a path of arrows leads from start to end."""
    pending, visited = [start], set()
    while pending:
        folder = pending.pop()
        for source, target in graph:
            if source == folder and target not in visited:
                if target == end:
                    return True
                visited.add(target)
                pending.append(target)
    return False


def transitive_reduction(graph):
    """Removes arrows that follow from others."""
    return {arrow for arrow in graph if not has_path(graph - {arrow}, *arrow)}


def diagram():
    """Returns the diagram as a Mermaid flowchart."""
    names = {folder: re.sub(r"\W", "_", folder) for folder in FOLDERS}
    lines = ["```mermaid", "flowchart TD"]
    lines += [f'  {names[folder]}["<b>{folder}</b><br>{purpose}"]' for folder, purpose in FOLDERS.items()]
    order = list(FOLDERS)
    drawn = sorted(transitive_reduction(arrows()), key=lambda arrow: tuple(map(order.index, arrow)))
    lines += [f"  {names[source]} --> {names[target]}" for source, target in drawn]
    return "\n".join([*lines, "```"])


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
