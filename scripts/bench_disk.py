# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks whether a folder has room for further results, so that a run stops before finished results are lost."""

import shutil

NEEDED = 32 * 2**20  # bytes: a record, its pictures, and temporary files


def nearly_full(folder):
    """Returns a message if the file system is nearly full, else "". Cheap enough to call often."""
    free = shutil.disk_usage(folder).free
    return f"{free / 2**20:.0f} MiB are free" if free < NEEDED else ""


def full(folder):
    """Returns a message if the folder is full, else "". Writes a file, so that quotas and limits count as well."""
    probe = folder / ".room"
    try:
        probe.write_bytes(bytes(2**16))
    except OSError as error:
        return error.strerror
    finally:
        try:
            probe.unlink(missing_ok=True)
        except OSError:
            pass
    return nearly_full(folder)
