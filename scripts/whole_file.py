# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Writes files whole or not at all, as the programs do: under a temporary name next to the final one, then renamed.
What a rename would destroy is written into: devices, pipes, and the file of standard output."""

import os
import tempfile
from pathlib import Path


def is_written_into(path):
    """Whether a rename would put a file in the place of something else."""
    if not path.exists():
        return False
    if not path.is_file():
        return True
    return any(os.path.samestat(path.stat(), os.fstat(standard)) for standard in open_standards())


def open_standards():
    """Descriptors of standard output and standard error that are open."""
    found = []
    for standard in (1, 2):
        try:
            os.fstat(standard)
            found.append(standard)
        except OSError:
            pass
    return found


def permissions_of(path):
    """Those of the file that is replaced, or of a new one."""
    if path.exists():
        return path.stat().st_mode & 0o7777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def write(path, text):
    """Follows symbolic links. Raises OSError."""
    path = Path(path)
    if is_written_into(path):
        with open(path, "a", encoding="utf-8") as file:
            file.write(text)
        return
    target = Path(os.path.realpath(path))
    part, name = tempfile.mkstemp(prefix=target.name[:100] + ".cbvh-part-", dir=target.parent)
    try:
        with open(part, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(name, permissions_of(target))
        os.replace(name, target)
    except BaseException:
        os.unlink(name)
        raise


def would_replace(path, inputs):
    """The first of some files that output to a path would replace, or None."""
    path = Path(path)
    if not path.is_file():
        return None
    return next((found for found in map(Path, inputs) if found.is_file() and found.samefile(path)), None)
