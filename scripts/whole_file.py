# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Writes files completely or not at all, as our programs do: under a temporary name in the same folder, then renamed.
Devices, pipes and the files of standard output and error are written in place, because a rename would replace them.
"""

import os
import tempfile
from pathlib import Path


def is_written_in_place(path):
    """True if a rename would replace something else than a regular file, or a file of standard output or error."""
    if not path.exists():
        return False
    if not path.is_file():
        return True
    return any(os.path.samestat(path.stat(), os.fstat(descriptor)) for descriptor in open_standards())


def open_standards():
    """Returns the descriptors of standard output and standard error that are open."""
    descriptors = []
    for descriptor in (1, 2):
        try:
            os.fstat(descriptor)
            descriptors.append(descriptor)
        except OSError:
            pass
    return descriptors


def permissions_of(path):
    """Permissions of the file to replace, or of a new file."""
    if path.exists():
        return path.stat().st_mode & 0o7777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def write(path, text):
    """Writes a text file. Follows symbolic links. Raises OSError."""
    path = Path(path)
    if is_written_in_place(path):
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
    """Returns the first of the inputs that writing to the path would replace, or None."""
    path = Path(path)
    if not path.is_file():
        return None
    return next((found for found in map(Path, inputs) if found.is_file() and found.samefile(path)), None)
