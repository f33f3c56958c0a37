# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Checks whether a folder has room for further results, so that a run stops before finished results are lost."""

import shutil

REQUIRED_BYTES = 32 * 2**20  # for a record, its pictures, and temporary files


def low_space_problem(folder):
    """Returns a message if less than REQUIRED_BYTES are free, else "". Cheap enough to call often."""
    free = shutil.disk_usage(folder).free
    return f"{free / 2**20:.0f} MiB are free" if free < REQUIRED_BYTES else ""


def write_problem(folder):
    """Returns a message if the folder cannot be written or has little space, else "". Writes a file, so that quotas
    and limits count as well."""
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
    return low_space_problem(folder)
