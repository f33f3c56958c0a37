# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Reads the records that cbvh_bench writes."""

import json

VERSION = 2

# Former names of members.
NEW_NAMES = {
    "exact_quads": "fallback_quads",
    "exact_quads_share": "fallback_quads_share",
    "frame_bytes": "header_bytes",
    "grid_bytes": "uncompressed_bytes",
    "grid_quads": "uncompressed_quads",
    "hits_beside_first_library": "hit_agreement",
    "leaf_bytes_are": "leaf_bytes_method",
    "max_border_gap": "max_border_mismatch",
    "other_distance": "different_distance",
    "other_hit_or_miss": "different_hit_or_miss",
    "other_ids": "different_ids",
    "other_number": "different_counts",
    "other_parity": "different_parities",
    "other_rays": "different_rays",
    "other_uv_or_normal": "different_uv_or_normal",
    "rmse_of_others_pixels": "inlier_rmse_pixels",
    "same_place_errors": "same_hit_errors",
    "same_place_rays": "same_hit_rays",
    "set": "ray_set",
    "turned_errors": "flipped_errors",
    "turned_rays": "flipped_rays",
    "uv_median_cells": "uv_median_quads",
    "uv_p99_cells": "uv_p99_quads",
}


class Damaged(Exception):
    """A record cannot be used. The text gives the reason in a few words."""


def renamed(node, new_name):
    """Returns a copy of nested JSON values whose members are called new_name(name)."""
    if isinstance(node, dict):
        return {new_name(name): renamed(value, new_name) for name, value in node.items()}
    return [renamed(value, new_name) for value in node] if isinstance(node, list) else node


def rename_leaves_only(record):
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
        rename_leaves_only(record)
    except (KeyError, TypeError) as error:
        raise Damaged(f"incomplete, lacks {error}") from error
    return renamed(record, lambda name: NEW_NAMES.get(name, name))
