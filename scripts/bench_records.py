# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Reads the records that cbvh_bench writes."""

import json

VERSION = 2


class Damaged(Exception):
    """A record cannot be used. The text gives the reason in a few words."""


def name_leaves(record):
    """Renames cLEAF to cLEAF-only in records made with --leaves-only, a former option."""
    if record["run"].get("settings", {}).pop("leaves_only", False):
        for result in (result for group in record["groups"] for result in group["results"]):
            for key in ("representation", "kind"):
                kind, mark, frame = result.get(key, "").partition("^")
                if kind == "cLEAF":
                    result[key] = "cLEAF-only" + mark + frame


def read(path):
    """Returns the contents of a record. Checks the entries that callers rely on; raises Damaged."""
    try:
        with open(path, encoding="utf-8") as file:
            record = json.load(file)
    except OSError as error:
        raise Damaged(f"cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise Damaged("truncated, or not JSON") from error
    if not isinstance(record, dict) or record.get("format") != "cbvh-bench":
        raise Damaged("not a record of cbvh_bench")
    if record.get("version") != VERSION:
        raise Damaged(f"format version {record.get('version')}: expected {VERSION}")
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
        name_leaves(record)
    except (KeyError, TypeError) as error:
        raise Damaged(f"incomplete, lacks {error}") from error
    return record
