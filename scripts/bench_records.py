# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Reading what cbvh_bench writes."""

import json

VERSION = 2


class Damaged(Exception):
    """A record that cannot be used; its text says why, in a few words."""


def name_leaves(record):
    """Calls cLEAF-only what was measured with --leaves-only, an option of before that had a name."""
    if record["run"].get("settings", {}).pop("leaves_only", False):
        for result in (result for group in record["groups"] for result in group["results"]):
            for key in ("representation", "kind"):
                kind, mark, frame = result.get(key, "").partition("^")
                if kind == "cLEAF":
                    result[key] = "cLEAF-only" + mark + frame


def read(path):
    """The contents of a record, checked for what its readers rely on."""
    try:
        with open(path, encoding="utf-8") as file:
            record = json.load(file)
    except OSError as error:
        raise Damaged(f"cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise Damaged("truncated or no JSON") from error
    if not isinstance(record, dict) or record.get("format") != "cbvh-bench":
        raise Damaged("no measurement of cbvh_bench")
    if record.get("version") != VERSION:
        raise Damaged(f"of format version {record.get('version')}, this reads {VERSION}")
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
