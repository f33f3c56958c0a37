# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Whether a folder has room for what is measured, so that a run stops before something finished is lost."""

import shutil

NEEDED = 32 * 2**20  # bytes: a record, its pictures, and what else is written meanwhile


def nearly_full(folder):
    """In words, or empty. Asks the file system alone, and may be called often."""
    free = shutil.disk_usage(folder).free
    return f"{free / 2**20:.0f} MiB are free" if free < NEEDED else ""


def full(folder):
    """In words, or empty. Writes a file, so that quotas and limits are seen, too."""
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
