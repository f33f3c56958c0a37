# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Reads the records that cbvh_bench writes."""

import json

VERSION = 2

# Names of members that only records of versions before 1.0 have.
FORMER_NAMES = ('"set": ', '"exact_quads": ', '"leaves_only": true')


class Damaged(Exception):
    """A record cannot be used. The text gives the reason in a few words."""


def read(path):
    """Returns the contents of a record. Checks the entries that callers rely on; raises Damaged."""
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
        record = json.loads(text)
    except OSError as error:
        raise Damaged(f"cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise Damaged("truncated, or not JSON") from error
    if not isinstance(record, dict) or record.get("format") != "cbvh-bench":
        raise Damaged("not a record of cbvh_bench")
    if record.get("version") != VERSION:
        raise Damaged(f"format version {record.get('version')}: expected {VERSION}")
    if any(name in text for name in FORMER_NAMES):
        raise Damaged("of a version before 1.0")
    try:
        record["run"]["commit"], record["run"]["command"]
        for group in record["groups"]:
            group["scene"], group["level"], group["quads"]
            for result in group["results"]:
                if "skipped" not in result:
                    result["memory"]["live_bytes"], result["views"], result["speed"]
                if "on_device" in result:
                    for key in ("device", "device_bytes", "imported_bytes", "upload_seconds"):
                        result["on_device"][key]
    except (KeyError, TypeError) as error:
        raise Damaged(f"incomplete, lacks {error}") from error
    return record
