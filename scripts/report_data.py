# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The measurements of a folder of records, flattened so that figures can ask for them."""

import math
import re
from pathlib import Path

import bench_records as records

KINDS = ("NAIVE", "GRID", "cGRID", "cVOXEL", "cLEAF", "cLEAF-only", "cVERT")
ISAS = ("sse2", "sse4.2", "avx", "avx2", "avx512")


def period(runs):
    """From the start of the first run to the end of the last, in words. Older records have no end."""
    begin, end = min(run["date"] for run in runs), max(run.get("end", run["date"]) for run in runs)
    return begin if begin == end else f"{begin} to {end}"


def device_of(record, result):
    """Name of the Vulkan device that a result is of; empty: of the processor."""
    asked = record["run"].get("settings", {}).get("device", "cpu")
    return result.get("on_device", {}).get("device") or ("" if asked == "cpu" else asked)


class Row:
    """One representation of one scene at one level on one instruction set."""

    def __init__(self, record, job, folder, group, result):
        self.run = record["run"]
        self.job, self.folder = job, folder
        self.is_generated = "--scene " in self.run["command"]
        self.scene, self.level, self.quads = group["scene"], group["level"], group["quads"]
        self.label, self.kind, self.isa = result["representation"], result["kind"], result["isa"]
        self.frame_level = result.get("frame_level")
        self.build_seconds = result["build_seconds"]
        self.memory = result["memory"]
        self.speeds = result["speed"]
        self.on_device = result.get("on_device")
        self.device = device_of(record, result)
        self.leaks, self.sheets, self.shadows = result.get("leaks"), result.get("sheets"), result.get("shadows", [])
        self.views = {view["view"]: view for view in result["views"]}

    @property
    def bytes(self):
        return self.memory["live_bytes"]

    @property
    def exact_share(self):
        """The part of cLEAF's quads that is stored exactly, as cVERT; None of other kinds."""
        if self.kind != "cLEAF":
            return None
        compression = self.memory["compression"]
        return compression["exact_quads"] / max(1, compression["quads"])

    @property
    def held_bytes(self):
        """What a Vulkan device holds, and what it uses in the host's memory."""
        return self.on_device["device_bytes"] + self.on_device["imported_bytes"]

    @property
    def held_per_quad(self):
        return self.held_bytes / self.quads

    @property
    def weight(self):
        """Of several that measured the same the one with the largest is shown: more rounds, more views, errors against
        the true surface, the latest."""
        settings = self.run["settings"]
        return settings["repeat"], len(self.views), settings.get("true_surface_hits", 0), self.run["date"]

    def errors(self, view, to_reference=False):
        """Errors of primary rays, or None."""
        found = self.views.get(view, {})
        return found.get("errors_to_reference_level" if to_reference else "errors")

    def speed(self, view, ray_set, query="closest", mode="single", threads=1):
        """A speed record, or None."""
        for s in self.speeds:
            if (s["view"], s["set"], s["query"], s["mode"], s["threads"]) == (view, ray_set, query, mode, threads):
                return s
        return None

    def image(self, view, what):
        """Path of a picture, or None when there is none."""
        name = self.views.get(view, {}).get(what)
        path = self.folder / "pictures" / self.job / Path(name).name if name else None
        return path if path and path.is_file() else None

    @property
    def command(self):
        """What measured it, without where the results went."""
        return re.sub(r" --(json|pictures|maps) ('[^']*'|\S+)", "", self.run["command"])


def job_of(path):
    return path.stem.rsplit("_L", 1)[0]


class Data:
    """rows are of the processor. What a Vulkan device measured is in gpu alone, so that no other section can show it; so
    is, in beside_gpu, what the processor measured for comparison with it."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.rows, self.runs, self.problems, self.skipped = [], [], [], []
        self.gpu, self.beside_gpu, self.gpu_skipped = [], [], []
        self.elsewhere = []  # rows of other machines or instruction sets, for the section on these alone
        self.checked = []  # rows with leaks, sheets or shadows
        for path in sorted(self.folder.glob("*.json")):
            record = self.read(path)
            if record:
                self.runs.append(record["run"])
                self.take(record, path, job_of(path).startswith("gpu_"))
        widest = [isa for isa in ISAS if any(row.isa == isa for row in self.rows)]
        self.isa = widest[-1] if widest else ""

    def add_gpu(self, path):
        """A record, or a folder of them, of which the section on the GPU is made and no other. They may be of another
        machine."""
        path = Path(path)
        for file in sorted(path.glob("*.json")) if path.is_dir() else [path]:
            record = self.read(file)
            if record:
                self.take(record, file, True)

    def add_elsewhere(self, folder):
        """Records of another machine, which the section on instruction sets shows beside this one's."""
        other = Data(folder)
        self.elsewhere += other.rows
        self.problems += other.problems

    def read(self, path):
        """A record, or None, and a line about it."""
        try:
            return records.read(path)
        except records.Damaged as error:
            self.problems.append(f"{path.name}: {error}")
            return None

    def take(self, record, path, for_gpu):
        """for_gpu: what is of the processor is there to be compared with a device."""
        job = job_of(path)
        for group in record["groups"]:
            for result in group["results"]:
                device = device_of(record, result)
                if "skipped" in result:
                    (self.gpu_skipped if device or for_gpu else self.skipped).append(
                        f"{group['scene']}, level {group['level']}, {result['representation']}"
                        f"{', ' + device if device else ''}: {result['skipped']}"
                    )
                    continue
                row = Row(record, job, path.parent, group, result)
                if device:
                    self.gpu.append(row)
                elif for_gpu:
                    self.beside_gpu.append(row)
                else:
                    if row.leaks or row.sheets or row.shadows:
                        self.checked.append(row)
                    if row.speeds or not job.startswith("checks_"):
                        self.rows.append(row)

    def is_own(self):
        """Whether all that was measured is of the user's own cages."""
        return bool(self.rows) and not any(row.is_generated for row in self.rows)

    def picture_level(self):
        """The level of the paper's pictures, or of one's own cage the finest below it."""
        levels = self.levels(self.main_scene()) if self.is_own() else []
        return 6 if 6 in levels or not levels else max([level for level in levels if level < 6] or levels)

    def scenes(self):
        return sorted({row.scene for row in self.rows})

    def levels(self, scene):
        return sorted({row.level for row in self.rows if row.scene == scene})

    def main_scene(self):
        """What speed and memory are shown of: trex, or else the largest."""
        names = self.scenes()
        if "trex" in names or not names:
            return "trex"
        return max(names, key=lambda name: max(row.quads for row in self.rows if row.scene == name))

    def pick(self, scene, level, label, view=None, job=None):
        """The row of a representation, of the widest instruction set and of most repeats; None without one."""
        found = [
            row
            for row in self.rows
            if (row.scene, row.level, row.label, row.isa) == (scene, level, label, self.isa)
            and (view is None or view in row.views)
            and (job is None or row.job == job)
        ]
        return max(found, key=lambda row: row.weight, default=None)

    def of_scene(self, scene, job=None):
        """Rows of a scene, one a level and representation."""
        keys = sorted(
            {
                (row.level, row.label)
                for row in self.rows
                if row.scene == scene and row.isa == self.isa and (job is None or row.job == job)
            }
        )
        return [row for row in (self.pick(scene, level, label, job=job) for level, label in keys) if row]


def median(values):
    ordered = sorted(values)
    n = len(ordered)
    return ordered[n // 2] if n % 2 else 0.5 * (ordered[n // 2 - 1] + ordered[n // 2])


def percentile(values, part):
    """By nearest rank."""
    return sorted(values)[min(len(values) - 1, int(part * len(values)))]


def uncertainty(speed):
    """Twice the standard deviation of the median of the ratios to GRID, as a part of it, were their noise normal: the
    middle half of a normal distribution is 1.35 deviations wide, that of the median of n is 1.25 / sqrt(n)."""
    return 2 * 1.25 * speed["relative_to_grid"]["spread"] / 1.35 / math.sqrt(len(speed["seconds"]))


def noise(rows):
    """Of the ratios to GRID, of all measurements but GRID's: their spread (middle half over median) and how sure their
    medians are. None without measurements; a device without a clock has none."""
    speeds = [s for row in rows if row.kind != "GRID" for s in row.speeds if s["relative_to_grid"]["spread"] is not None]
    if not speeds:
        return None
    spreads = [s["relative_to_grid"]["spread"] for s in speeds]
    unsure = [uncertainty(s) for s in speeds]
    return {
        "median": median(spreads),
        "max": max(spreads),
        "beyond": sum(s > 0.05 for s in spreads),
        "count": len(spreads),
        "unsure": median(unsure),
        "unsure_95": percentile(unsure, 0.95),
    }


def judged(found):
    """What noise found, in words."""
    if found["beyond"] < 0.1 * found["count"]:
        return "a quiet run"
    if found["median"] < 0.05:
        return "some noise, ratios are good to a few percent"
    return "a noisy run, take speeds as rough"


def compare_runs(data, other):
    """How far the medians of ratios to GRID of two runs are apart, or None."""
    differences = []
    for row in data.rows:
        if row.kind == "GRID":
            continue
        twin = next(
            (
                r
                for r in other.rows
                if (r.job, r.scene, r.level, r.label, r.isa) == (row.job, row.scene, row.level, row.label, row.isa)
            ),
            None,
        )
        for s in row.speeds if twin else []:
            t = twin.speed(s["view"], s["set"], s["query"], s["mode"], s["threads"])
            if t:
                a, b = s["relative_to_grid"]["median"], t["relative_to_grid"]["median"]
                differences.append(abs(a - b) / (0.5 * (a + b)))
    if not differences:
        return None
    return {
        "median": median(differences),
        "p95": percentile(differences, 0.95),
        "max": max(differences),
        "beyond": sum(d > 0.05 for d in differences),
        "count": len(differences),
    }


def relative_speeds(data, kind, scene, levels=(4, 5, 6), view="full", frame_levels=(None, 2, 3)):
    """Ratios to GRID of a kind at some frame levels, single rays, closest hit, both ray sets. The paper's ranges are of
    frame levels 2 and 3; NAIVE has none."""
    ratios = []
    for row in data.of_scene(scene):
        if row.kind == kind and row.level in levels and row.frame_level in frame_levels:
            for ray_set in ("coherent", "incoherent"):
                speed = row.speed(view, ray_set)
                if speed:
                    ratios.append(speed["relative_to_grid"]["median"])
    return ratios
