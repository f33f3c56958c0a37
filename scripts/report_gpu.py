# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on GPUs: the paper's figures 16 and 17 there, as speed against memory.

A device is one on one machine. What it measured is shown a scene and view at a time, and ratios to
the processor are to one thread of the same machine, in the same pictures.
"""

from html import escape

import report_data as d
import report_figures as f
import report_gpu_chart as gpu_chart
import report_page as p
import report_robustness as checks

# set, query, and what they are called
RAYS = (
    ("coherent", "closest", "coherent"),
    ("incoherent", "closest", "incoherent"),
    ("coherent", "any", "coherent, any hit"),
    ("incoherent", "any", "incoherent, any hit"),
)
DRAWN = (RAYS[0], RAYS[1], RAYS[3])
# bytes of a buffer that many things share, and that may be almost empty: Arena in kernels/vulkan/host/memory.cpp
SHARED_BUFFER = 2**20
SAME_PICTURE = ("width", "height", "max_error_diagonals", "position")

MISSING = "speeds on a Vulkan device: scripts/benchmark.py gpu-quick, and scripts/report.py --gpu with its folder"
TEXT = (
    "<p>The same blocks, byte for byte, traced on a Vulkan device: figure 16 (speed, its upper row) against figure 17 "
    "(memory), a mark with its number for each level. Rays are those of figure 16, all of a picture in one call, timed by "
    "the device's own clock. Memory is what the device holds, in buffers of 16 KiB to 16 MiB and more, which is most of it "
    "where a scene is small, and then no chart is drawn; and what it <i>imports</i>, blocks in the host's memory that it "
    "uses in place, as it does where both are the same. Beside each speed stands how many times that of GRID and of NAIVE "
    "on the device it is, and that of one thread of the same machine (CPU), where these were measured. A device in "
    "software, such as llvmpipe, has all threads.</p>"
)


class Shown:
    """What a device measured of a scene in a view. rows: {(level, quads): {representation: row}}."""

    def __init__(self, scene, view, rows):
        self.scene, self.view, self.rows = scene, view, {}
        for row in sorted(rows, key=lambda row: (row.run["settings"]["repeat"], row.run["date"])):
            if row.scene == scene and any(s["view"] == view for s in row.speeds):
                self.rows.setdefault((row.level, row.quads), {})[row.label] = row

    @property
    def title(self):
        return self.scene + ("" if self.view == "full" else f", {self.view} view")

    def sizes(self):
        """Levels, and numbers of quads where a scene has several."""
        return sorted(self.rows)

    def main_size(self):
        """The finest of those with most representations."""
        return max(self.rows, key=lambda size: (len(self.rows[size]), size))

    def size_name(self, size):
        several = len([other for other in self.rows if other[0] == size[0]]) > 1
        return f"level {size[0]}" + (f", {size[1] / 1e6:.0f} million quads" if several else "")

    def labels(self):
        return sorted({label for rows in self.rows.values() for label in rows}, key=f.sort_key)

    def all_rows(self):
        return [rows[label] for _, rows in sorted(self.rows.items()) for label in sorted(rows, key=f.sort_key)]


class Device:
    def __init__(self, name, run, data):
        self.name, self.run = name, run
        self.rows = [row for row in data.gpu if row.on_device and (row.device, machine(row.run)) == (name, machine(run))]
        self.processor = [row for row in data.rows + data.beside_gpu if machine(row.run) == machine(run)]
        names = sorted({(row.scene, s["view"]) for row in self.rows for s in row.speeds}, key=self.order)
        self.shown = [shown for shown in (Shown(scene, view, self.rows) for scene, view in names) if shown.rows]

    def order(self, name):
        """trex first, or else the largest; full before close."""
        scene, view = name
        return (scene != "trex", -max(row.quads for row in self.rows if row.scene == scene), scene, view != "full", view)

    def beside(self, row):
        """The same on the processor, or None."""
        found = [other for other in self.processor if same(row, other)]
        return max(found, key=lambda other: (other.run["settings"]["repeat"], other.run["date"]), default=None)


def machine(run):
    return (run["cpu"], run["hardware_threads"])


def same(a, b):
    pictures = [[row.run["settings"].get(key) for key in SAME_PICTURE] for row in (a, b)]
    return (a.scene, a.level, a.quads, a.label) == (b.scene, b.level, b.quads, b.label) and pictures[0] == pictures[1]


def devices(data):
    """GPUs before devices in software."""
    found = {(row.device, machine(row.run)): row.run for row in data.gpu if row.on_device}
    return [Device(key[0], found[key], data) for key in sorted(found, key=lambda key: ("llvmpipe" in key[0], key))]


# --- numbers ------------------------------------------------------------------------------


def speed(row, view, rays):
    """Millions of rays a second, or None."""
    found = row.speed(view, rays[0], rays[1]) if row else None
    return found["mrays_per_second"]["median"] if found else None


def to_grid(row, view, rays):
    found = row.speed(view, rays[0], rays[1]) if row else None
    return found["relative_to_grid"]["median"] if found else None


def to_naive(row, naive, view, rays):
    """Through GRID, which is in the same run as either."""
    ours, theirs = to_grid(row, view, rays), to_grid(naive, view, rays)
    return ours / theirs if ours and theirs else None


def to_processor(row, beside, view, rays):
    ours, theirs = speed(row, view, rays), speed(beside, view, rays)
    return ours / theirs if ours and theirs else None


def digits(value):
    """Three of them."""
    return f"{value:.{3 if value < 1 else 2 if value < 10 else 1 if value < 100 else 0}f}"


def ratio(value):
    """With two digits behind the point, but for large ones."""
    return f"{value:.2f}" if value < 10 else digits(value)


def text(value, form=digits):
    return form(value) if value else "-"


def part(row, grid):
    """Of GRID's memory on the device."""
    return row.held_per_quad / grid.held_per_quad if grid else None


# --- in words -----------------------------------------------------------------------------


def listed(words):
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]


def smallest(rows):
    """Those that take least; which of them does, buffers decide that are not full. None if that is GRID's case, too."""
    least = min(row.held_bytes for row in rows.values())
    found = {label: row for label, row in rows.items() if row.held_bytes < least + SHARED_BUFFER}
    return None if "GRID" in found or len(found) == len(rows) else found


def spans(values, form):
    low, high = form(min(values)), form(max(values))
    return low if low == high else f"{low} to {high}"


def smallest_in_words(shown, rows):
    small, grid = smallest(rows), rows.get("GRID")
    if not small:
        return "memory is that of a few buffers, and does not tell representations apart"
    names = listed([p.label(label) for label in sorted(small, key=f.sort_key)])
    words = f"{names} {'is' if len(small) == 1 else 'are'} the smallest with "
    words += spans([row.held_per_quad for row in small.values()], digits) + " bytes a quad"
    if not grid:
        return words
    shares = spans([100 * part(row, grid) for row in small.values()], "{:.0f}".format)
    words += f", {shares}% of GRID's {digits(grid.held_per_quad)}"
    speeds = []
    for rays in RAYS:
        times = [found for found in (to_grid(row, shown.view, rays) for row in small.values()) if found]
        speeds += [f"{spans(times, ratio)} ({rays[2]})"] if times else []
    return words + (f", at {listed(speeds)} times GRID's speed" if speeds else "")


def fastest_in_words(shown, rows):
    words = []
    for rays in RAYS[:2]:
        known = [row for row in rows.values() if to_grid(row, shown.view, rays)]
        if len(known) > 1:
            row = max(known, key=lambda row: to_grid(row, shown.view, rays))
            times = f" ({ratio(to_grid(row, shown.view, rays))} times GRID)" if row.kind != "GRID" else ""
            words.append(f"with {rays[2]} rays {p.label(row.label)}{times}")
    return "the fastest is " + listed(words) if words else ""


def processor_in_words(device, shown, rows):
    ratios = [to_processor(row, device.beside(row), shown.view, rays) for row in rows.values() for rays in RAYS]
    ratios = [found for found in ratios if found]
    if not ratios:
        return ""
    return f"the device has {ratio(min(ratios))} to {ratio(max(ratios))} times the speed of one thread of its processor"


def in_words(device, shown):
    """What the tables show, in a sentence."""
    size = shown.main_size()
    rows = shown.rows[size]
    parts = [smallest_in_words(shown, rows), fastest_in_words(shown, rows), processor_in_words(device, shown, rows)]
    return f"<p><b>{escape(shown.title)}, {shown.size_name(size)}:</b> {'; '.join(filter(None, parts))}.</p>"


def noise_in_words(rows):
    found = d.noise(rows)
    if not found:
        return ""
    return (
        f"<p><b>Noise.</b> The middle half of the ratios to GRID of a combination spreads by {100 * found['median']:.0f}% "
        f"(median of {found['count']}; the worst {100 * found['max']:.0f}%): {d.judged(found)}. By that, a median is good to "
        f"{100 * found['unsure']:.0f}%, 95 of 100 to {100 * found['unsure_95']:.0f}%, and ratios that are closer do not "
        "differ.</p>"
    )


# --- charts and tables --------------------------------------------------------------------


def charts(shown):
    """None where memory does not tell representations apart."""
    parts = []
    if not smallest(shown.rows[shown.main_size()]):
        return ""
    for rays in DRAWN:
        lines = {}
        for row in shown.all_rows():
            if speed(row, shown.view, rays):
                lines.setdefault(row.label, []).append((row.held_per_quad, speed(row, shown.view, rays), row.level))
        if lines:
            title = f"{shown.title}, {rays[2]}"
            parts.append(p.chart(gpu_chart.speed_against_memory(title, lines), f"Speed against memory on a GPU, {title}"))
    return p.charts(parts) if parts else ""


def speed_table(device, shown, size):
    """Speeds, and beside each how many times those of GRID, NAIVE and the processor. What was not measured at all has no
    column."""
    rows = [shown.rows[size][label] for label in sorted(shown.rows[size], key=f.sort_key)]
    naive, beside = shown.rows[size].get("NAIVE"), [device.beside(row) for row in rows]
    measured = [rays for rays in RAYS if any(speed(row, shown.view, rays) for row in rows)]
    columns = {
        "Mrays/s": lambda i, rays: text(speed(rows[i], shown.view, rays)),
        "GRID": lambda i, rays: text(to_grid(rows[i], shown.view, rays), ratio),
        "NAIVE": lambda i, rays: text(to_naive(rows[i], naive, shown.view, rays), ratio),
        "CPU": lambda i, rays: text(to_processor(rows[i], beside[i], shown.view, rays), ratio),
    }
    cells = {name: [[cell(i, rays) for i in range(len(rows))] for rays in measured] for name, cell in columns.items()}
    heads = [name for name, of_rays in cells.items() if any(set(column) != {"-"} for column in of_rays)]
    table = [
        (
            f'{p.label(row.label)} <span class="soft">{digits(row.held_per_quad)} B</span>',
            [cells[head][k][i] for k in range(len(measured)) for head in heads],
        )
        for i, row in enumerate(rows)
    ]
    title = f"{escape(shown.title)}, {shown.size_name(size)}, speed, and how many times that of GRID, NAIVE and CPU"
    return f"<h4>{title}</h4>" + p.grouped_table([rays[2] for rays in measured], heads, table)


def memory_table(shown):
    sizes, table = shown.sizes(), []
    for label in shown.labels():
        cells = []
        for size in sizes:
            row = shown.rows[size].get(label)
            cells += memory_cells(row, shown.rows[size].get("GRID")) if row else ["-"] * 4
        table.append((p.label(label), cells))
    title = (
        f"<h4>{escape(shown.title)}, memory: MiB on the device and imported, bytes a quad, and how many times that of "
        "GRID</h4>"
    )
    heads = ["device", "imported", "a quad", "GRID"]
    return title + p.grouped_table([shown.size_name(size) for size in sizes], heads, table)


def memory_cells(row, grid):
    held = [row.on_device[key] / 2**20 for key in ("device_bytes", "imported_bytes")]
    share = part(row, grid)
    return [digits(mib) if mib else "0" for mib in held] + [digits(row.held_per_quad), text(share, ratio)]


def builds(shown):
    """What the other tables leave out."""
    sizes, table = shown.sizes(), []
    for label in shown.labels():
        cells = []
        for size in sizes:
            row = shown.rows[size].get(label)
            cells += build_cells(row, shown.view) if row else ["-"] * 5
        table.append((p.label(label), cells))
    title = "bytes a quad in Embree, seconds of the build and of the copy to the device, error in pixels"
    heads = ["a quad", "build", "copy", "median", "p99"]
    names = [shown.size_name(size) for size in sizes]
    return f"<h4>{escape(shown.title)}, before it is traced: {title}</h4>" + p.grouped_table(names, heads, table)


def build_cells(row, view):
    errors = row.errors(view)
    seconds = [f"{value:.2f}" for value in (row.build_seconds, row.on_device["upload_seconds"])]
    pixels = [f.error_text(errors[key]) if errors else "-" for key in ("median_pixels", "p99_pixels")]
    return [digits(row.memory["bytes_per_quad"]), *seconds, *pixels]


def device_checks(device):
    """Leaks and the like, if they were looked for on the device."""
    body = ""
    for what, table in (("leaks", checks.leaks_table), ("sheets", checks.sheets_table), ("shadows", checks.shadows_table)):
        rows = sorted((row for row in device.rows if getattr(row, what)), key=checks.order)
        body += f"<h4>{what.capitalize()}</h4>" + table(rows) if rows else ""
    return p.folded("Leaks, sheets and shadows on the device, as in their section", body)


def facts(device):
    run, commits = device.run, sorted({row.run["commit"] for row in device.rows})
    when = d.period([row.run for row in device.rows])
    return (
        f'<p class="soft">Measured {escape(when)}, commit {escape(", ".join(commits))}; its '
        f"machine has a processor {escape(run['cpu'])} with {run['hardware_threads']} threads.</p>"
    )


def device_part(device):
    title = f"<h3>{escape(device.name)}</h3>" + facts(device)
    if not device.shown:
        return title + device_checks(device)
    main, others = device.shown[0], device.shown[1:]
    levels = "".join(speed_table(device, main, size) for size in main.sizes() if size != main.main_size())
    out = title + in_words(device, main) + noise_in_words(device.rows) + charts(main)
    out += speed_table(device, main, main.main_size()) + memory_table(main)
    out += p.folded(f"{main.title}, the other levels, and builds", levels + builds(main))
    for shown in others:
        tables = "".join(speed_table(device, shown, size) for size in reversed(shown.sizes()))
        tables += memory_table(shown) + builds(shown)
        out += p.folded(shown.title, in_words(device, shown) + charts(shown) + tables)
    return out + device_checks(device)


def section(data):
    found = devices(data)
    if not found:
        return p.section("gpu", "GPU: speed against memory", p.missing(MISSING))
    skipped = "".join(f'<p class="missing">{escape(line)}</p>' for line in data.gpu_skipped)
    return p.section(
        "gpu",
        "GPU: speed against memory",
        TEXT,
        *(device_part(device) for device in found),
        skipped,
        commands=[row.command for row in data.gpu + data.beside_gpu],
    )


def markdown(data):
    """For the README: the main scene of each device at its main size."""
    lines = []
    for device in devices(data):
        for shown in device.shown[:1]:
            size = shown.main_size()
            lines += [f"{device.name}; {shown.title}, {shown.size_name(size)}, {size[1] / 1e6:.2f} million quads", ""]
            lines += ["| | bytes a quad | " + " | ".join(f"{rays[2]}, Mrays/s | of GRID" for rays in RAYS) + " |"]
            lines += ["|:--|--:|" + "--:|" * (2 * len(RAYS))]
            for label in sorted(shown.rows[size], key=f.sort_key):
                row = shown.rows[size][label]
                cells = [label, digits(row.held_per_quad)]
                for rays in RAYS:
                    cells += [text(speed(row, shown.view, rays)), text(to_grid(row, shown.view, rays), ratio)]
                lines.append("| " + " | ".join(cells) + " |")
            lines.append("")
    return lines
