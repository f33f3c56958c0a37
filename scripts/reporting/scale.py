# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Scale: the herd of ten billion quads, and levels by the view, as scripts/measure_scale.py measured them."""

import json
from pathlib import Path

import pandas

from .data import RAY_SETS
from .formats import Table, table

RECORD = "scale.json"
GIB = 2**30
SPEEDS = [(f"million {rays} rays per second", f"speed_{rays}_closest_mrays_per_second", "{:.2f}") for rays in RAY_SETS]
LEVELS = [
    ("", lambda row: f"{row.scene}, {row['view']}", str), ("level", "level", str),
    ("million quads", lambda row: row.quads / 1e6, "{:.2f}"), ("MiB", lambda row: row.live_bytes / 2**20, "{:.1f}"),
    ("build, s", "build_seconds", "{:.2f}"),
    ("error to the true surface, pixels: median", "errors_to_true_surface_median_pixels", "{:.3f}"),
    ("p99", "errors_to_true_surface_p99_pixels", "{:.3f}"), *SPEEDS,
]  # fmt: skip


def read(folder):
    """Returns the record, or None."""
    path = Path(folder) / RECORD
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def gib(count):
    return f"{count / GIB:,.1f} GiB" if count < 1000 * GIB else f"{count / GIB / 1024:,.1f} TiB"


def herd_table(herd):
    """The herd from a file, and the memory that representations of Embree would require, computed from the copies that
    fitted."""
    part, memory, rows = herd["from_file"], herd["memory"], []
    own = f"{gib(herd['render_anonymous_bytes'])}, and {gib(herd['file_bytes'])} on disk"
    found = [("cVERT, from a file", herd, own, "whatever the disk holds", herd["warm"]["speed"])]
    found += [(f"cVERT, {part['count']} copies from a file", part, "-", "-", part["speed"])]
    for other in herd["in_memory"]:
        each, name = other["bytes"] / other["quads"], f"{other['representation']}, {other['count']} copies in memory"
        total = f"{gib(each * herd['quads'])}, computed from {each:.1f} bytes per quad"
        most = f"{memory / (other['peak_bytes'] / other['quads']) / 1e9:.2f} billion"
        found.append((name, other, total, most, other["speed"]))
    for name, of, total, most, speed in found:
        speeds = [f"{speed[rays]['closest']['mrays_per_second']:.2f}" for rays in RAY_SETS]
        rows.append([name, f"{of['quads'] / 1e9:.2f} billion", total, most, *speeds])
    heads = ["", "quads", "memory for the whole herd", f"quads that can be built in {gib(memory)}"]
    return Table(heads + [head for head, *_ in SPEEDS], rows)


def herd_text(herd):
    """A paragraph on how the herd was built and opened."""
    ends, mib = {"SIGINT": "interrupted", "SIGKILL": "killed"}, 2**20
    stops = " and ".join(f"{ends[stop['signal']]} at {gib(stop['bytes'])}" for stop in herd["stops"])
    cold, warm = (herd[state]["open_seconds"] * 1e3 for state in ("cold", "warm"))
    return (
        f"{herd['count']} T-rexes, each in a pose of its own, at level {herd['level']}: {herd['quads']:,} quads, "
        f"{herd['file_bytes'] / herd['quads']:.2f} bytes each. Built in {herd['build_seconds'] / 60:.1f} minutes on "
        f"{herd['threads']} threads, {herd['last_quads'] / herd['last_seconds'] / 1e6:.1f} million quads per second, "
        f"with at most {herd['anonymous_bytes'] / mib:,.0f} MiB of the program's memory, "
        f"{herd['device_bytes'] / mib:,.0f} of them the kernels'; {stops}, and resumed each time. Opened in "
        f"{cold:.0f} ms with nothing of it in memory, and in {warm:.0f} ms again. A picture of {herd['size']} "
        f"with {herd['samples']} samples per pixel then takes "
        f"{herd['cold']['picture_seconds']:.1f} s; rays meet {gib(herd['cold_mapped_bytes'])} of the file. Other "
        f"representations have as many copies as they can build in {gib(herd['memory'])}. Speeds: one thread, single "
        "rays."
    )


def tables(record):
    """Returns the texts and tables of a record."""
    parts = [herd_text(record["herd"]), herd_table(record["herd"])] if "herd" in record else []
    if "levels" in record:
        title = "Levels by the view: level auto gives each edge about one quad per pixel"
        parts.append(table(pandas.json_normalize(record["levels"], sep="_"), LEVELS, 2, title))
    return parts
