#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks that each source of the kernels includes the headers that it uses: builds with clang have no precompiled
header that provides them.

    own_includes.py COMPILE_COMMANDS

Takes the first command of each source from compile_commands.json and checks syntax only.
"""

import json
import sys

from compile_commands import syntax_check


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        commands = json.load(file)
    entries = {}
    for entry in commands:
        if "/upstream/kernels/cbvh/" in entry["file"]:
            entries.setdefault(entry["file"], entry)
    failures = 0
    for path, entry in sorted(entries.items()):
        run = syntax_check(entry, "-w")
        if run.returncode != 0:
            failures += 1
            print(f"{path}:\n{run.stderr[:2000]}")
    print(f"{len(entries)} sources, {failures} do not compile")
    sys.exit(failures != 0 or not entries)


main()
