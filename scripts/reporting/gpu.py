# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Speed and memory on Vulkan devices. The same device on different machines counts as different devices. Ratios to the
CPU refer to one thread of the same machine and the same pictures."""

from .data import in_order
from .formats import digits, pixels, ratio, table

RAYS = {"coherent": "coherent", "incoherent": "incoherent", "coherent_any": "coherent, any hit"}
RAYS |= {"incoherent_any": "incoherent, any hit"}
MACHINE, PLACE = ["run_cpu", "run_hardware_threads"], ["scene", "view", "level", "quads"]
SAME = [*PLACE, *MACHINE, "representation", "position"]
SAME += [f"run_settings_{key}" for key in ("width", "height", "max_error_diagonals")]
COLUMNS = [
    ("level", "level", str), ("", "representation", str), ("million quads", lambda row: row.quads / 1e6, "{:.2f}"),
    ("device, MiB", lambda row: row.on_device_device_bytes / 2**20, digits),
    ("imported, MiB", lambda row: row.on_device_imported_bytes / 2**20, digits),
    ("bytes per quad", "held_per_quad", digits), ("of GRID", "part", ratio),
]  # fmt: skip
SPEEDS = {"Mrays/s": ("", digits)} | {f"of {name}": (f"_of_{name.lower()}", ratio) for name in ("GRID", "NAIVE", "CPU")}
BUILDS = [
    ("in Embree, bytes per quad", "memory_bytes_per_quad", digits), ("build, s", "build_seconds", "{:.2f}"),
    ("copy, s", "on_device_upload_seconds", "{:.2f}"), ("error: median", "errors_median_pixels", pixels),
    ("error: p99", "errors_p99_pixels", pixels),
]  # fmt: skip


def device_views(data):
    """Views that devices measured, with the bytes on the device, and ratios to GRID, to NAIVE and to one CPU thread."""
    views = data.every_view.assign(position=data.every_view.run_settings_position.map(str))
    views = views.sort_values(["run_settings_repeat", "run_date"], kind="stable")
    rows = views[(views.origin == "gpu") & views.on_device_device_bytes.notna() & (views["speeds"] > 0)]
    rows = rows.drop_duplicates([*SAME, "device"], keep="last")
    cpu = views[views.origin.isin(("here", "gpu baseline"))].drop_duplicates(SAME, keep="last")[[*SAME, *RAYS]]
    rows = rows.merge(cpu, "left", SAME, suffixes=("", "_cpu"))
    rows["held_bytes"] = rows.on_device_device_bytes + rows.on_device_imported_bytes
    rows["held_per_quad"] = rows.held_bytes / rows.quads
    keys = ["device", *MACHINE, *PLACE]
    for kind in ("GRID", "NAIVE"):
        others = rows[rows.kind == kind].drop_duplicates(keys, keep="last")
        others = others[[*keys, "held_per_quad", *(f"{rays}_of_grid" for rays in RAYS)]]
        rows = rows.merge(others, "left", keys, suffixes=("", f"_{kind}"))
    for rays in RAYS:
        rows[f"{rays}_of_naive"] = rows[f"{rays}_of_grid"] / rows[f"{rays}_of_grid_NAIVE"]
        rows[f"{rays}_of_cpu"] = rows[rays] / rows[f"{rays}_cpu"]
    return rows.assign(part=rows.held_per_quad / rows.held_per_quad_GRID)


def section(data):
    """A table for each device, scene and view."""
    rows, parts = device_views(data), []
    for (device, scene, view), found in rows.groupby(["device", "scene", "view"]):
        columns = list(COLUMNS)
        for rays in [rays for rays in RAYS if found[rays].notna().any()]:
            ends = [(head, rays + end, form) for head, (end, form) in SPEEDS.items()]
            columns += [(f"{RAYS[rays]}: {head}", name, form) for head, name, form in ends if found[name].notna().any()]
        title = f"{scene}, {view} view, on {device}"
        parts.append(table(in_order(found, "level", "quads", "representation"), [*columns, *BUILDS], 2, title))
    return parts + data.skipped("gpu", "gpu baseline")
