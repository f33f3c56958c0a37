# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The build's compile commands, changed to check the syntax of a source alone."""

import re
import shlex
import subprocess


def syntax_check(entry, *options):
    """Checks the syntax of the source of an entry of compile_commands.json, without the build's precompiled header.
    Returns the finished process, with its output as text. options: added to the command."""
    arguments = shlex.split(entry["command"])
    for option in ("-o", "-include"):  # -include: the precompiled header
        if option in arguments:
            first = arguments.index(option)
            del arguments[first : first + 2]
    compiler = next(i for i, word in enumerate(arguments) if re.search(r"(\+\+|clang|gcc|cc)(-[\d.]+)?$", word))
    return subprocess.run(
        arguments[compiler:] + ["-O0", "-fsyntax-only", *options],
        cwd=entry["directory"],
        capture_output=True,
        text=True,
        check=False,
    )
