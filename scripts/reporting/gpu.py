# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Speed and memory on Vulkan devices. The same device on different machines counts as different devices. Ratios to the
CPU refer to one thread of the same machine and the same pictures."""

from . import checks
from . import figures as f
from .data import in_order
from .formats import Fold, Title, digits, pixels, ratio, table, value_range
from .noise import noise

RAYS = {"coherent": "coherent", "incoherent": "incoherent", "coherent_any": "coherent, any hit"}
RAYS |= {"incoherent_any": "incoherent, any hit"}
GRANULARITY = 2**20  # bytes: buffers of Arena in kernels/vulkan/host/memory.cpp are used in part
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


def least_memory(rows):
    """Returns the rows with the least memory, within the granularity of shared buffers; none if GRID or all rows are
    among them."""
    found = rows[rows.held_bytes < rows.held_bytes.min() + GRANULARITY]
    return found[:0] if "GRID" in set(found.kind) or len(found) == len(rows) else found


def draw(axes, rows, title, rays):
    """Draws a line for each representation, with a numbered mark for each level."""
    seen = set()
    for label, found in rows.sort_values("level").groupby("representation", sort=False):
        kind = found.kind.iloc[0]
        color, mark = f.KINDS[kind]
        style = {"color": color, "marker": mark, "mfc": "none" if kind in seen else color, "linewidth": 1}
        axes.plot(found.held_per_quad, found[rays], label=f.math_label(label), **style)
        seen.add(kind)
        for x, y, level in zip(found.held_per_quad, found[rays], found.level):
            axes.annotate(level, (x, y), xytext=(0, 5), textcoords="offset points", ha="center", fontsize=8)
    f.log_axis(axes, "x", rows.held_per_quad.min() / 1.5, rows.held_per_quad.max() * 1.5)
    axes.set_ylim(0, 1.12 * rows[rays].max())
    f.set_labels(axes, title, "bytes per quad, on the device and imported", "million rays per second")


def summary(rows, ray_sets):
    """A sentence on the smallest and the fastest representation and on the ratio to one CPU thread. ray_sets: those
    that were measured."""
    small, texts = least_memory(rows), []
    if len(small):
        times = ", ".join(f"{value_range(small[f'{rays}_of_grid'], ratio)} ({RAYS[rays]})" for rays in ray_sets)
        size, part = value_range(small.held_per_quad, digits), value_range(100 * small.part, "{:.0f}%".format)
        names = ", ".join(small.representation)
        texts += [f"smallest: {names} with {size} bytes per quad, {part} of GRID, at {times} times GRID's speed"]
    else:
        texts += ["memory consists of a few shared buffers and does not distinguish representations"]
    for rays in ray_sets[:2]:
        speeds = rows.set_index("representation")[f"{rays}_of_grid"]
        texts += [f"fastest with {RAYS[rays]} rays: {speeds.idxmax()} ({ratio(speeds.max())} times GRID)"]
    cpu = [value for rays in ray_sets for value in rows[f"{rays}_of_cpu"].dropna()]
    if cpu:
        texts.append(f"{value_range(cpu, ratio)} times the speed of one thread of the processor")
    return "; ".join(texts) + "."


def of_scene(rows, name):
    """Facts at the finest level with the most representations, charts if memory distinguishes these, and the table."""
    rows = in_order(rows, "level", "quads", "representation")
    ray_sets = [rays for rays in RAYS if rows[rays].notna().any()]
    counts = rows.groupby(["level", "quads"]).representation.nunique()
    level, quads = max(counts.index, key=lambda size: (counts[size], size))
    main, charts, speeds = rows[(rows.level == level) & (rows.quads == quads)], [], []
    for rays in ray_sets:
        title, text = f"{name}, {RAYS[rays]}", f"Speed against memory on a GPU, {name}, {RAYS[rays]}"
        shown = len(least_memory(main)) and rays != "coherent_any"
        charts += [f.chart(text, 3.9, draw, rows[rows[rays].notna()], title, rays)] if shown else []
        ends = [(head, rays + end, form) for head, (end, form) in SPEEDS.items()]
        speeds += [(f"{RAYS[rays]}: {head}", column, form) for head, column, form in ends if rows[column].notna().any()]
    sentence = f"{name}, level {level}, {quads / 1e6:.3g} million quads: {summary(main, ray_sets)}"
    return [sentence, charts, table(rows, [*COLUMNS, *speeds, *BUILDS], 2, f"{name}: memory, speed, builds and errors")]


def section(data):
    """Devices, GPUs before software devices. The scenes of each device: trex first, or else the largest."""
    rows, parts, every = device_views(data), [], data.table[data.table.on_device_device_bytes.notna()]
    every = every.assign(software=every.device.str.contains("llvmpipe"))
    for (_, device, cpu, threads), found in every.groupby(["software", "device", *MACHINE]):
        end, commits = found.run_end.fillna(found.run_date).max(), ", ".join(sorted(set(found.run_commit)))
        dates = f"{found.run_date.min()} to {end}, commit {commits}"
        parts += [Title(device), f"Measured {dates}, processor {cpu}, {threads} threads."]
        own = rows[(rows.device == device) & (rows.run_cpu == cpu) & (rows.run_hardware_threads == threads)]
        scenes = [(scene != "trex", -part.quads.max(), scene, view != "full", view, part)
                  for (scene, view), part in own.groupby(["scene", "view"])]  # fmt: skip
        for i, (*_, scene, _, view, part) in enumerate(sorted(scenes, key=lambda scene: scene[:-1])):
            name = scene + ("" if view == "full" else f", {view} view")
            shown = of_scene(part, name)
            parts += [noise(found), *shown] if i == 0 else [Fold(name, shown)]
        parts += [Fold("Leaks, sheets and shadows on the device", checks.tables(found))]
    commands = data.table[data.table.origin.isin(("gpu", "gpu baseline"))].command
    return parts + data.skipped("gpu", "gpu baseline") if parts else [], commands
