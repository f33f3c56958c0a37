# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The data of the sections: the table of all records. If several rows measured the same, one of them is kept: the one
with the most rounds, the most views, errors against the true surface, or the latest date."""

from pathlib import Path

from . import records

KINDS = ("NAIVE", "NAIVE-compact", "GRID", "cGRID", "cVOXEL", "cLEAF", "cLEAF-only", "cVERT", "cTILE")
ISAS = ("sse2", "sse4.2", "avx", "avx2", "avx512")
MAIN_SCENE = "trex"  # of the paper
RAY_SETS = ("coherent", "incoherent")
SAME = ["scene", "level", "representation"]
WEIGHT = ["run_settings_repeat", "view_count", "run_settings_true_surface_hits", "run_date"]


def label_order(label):
    kind, _, frame = label.partition("^")
    return (KINDS.index(kind) if kind in KINDS else len(KINDS), frame)


def in_order(frame, *keys):
    """Returns the frame sorted by the keys; representations are in the order of KINDS."""
    ranks = {label: rank for rank, label in enumerate(sorted(set(frame.representation), key=label_order))}
    return frame.sort_values([*keys], key=lambda column: column.map(ranks) if column.name == SAME[2] else column)


def with_speeds(table):
    """A row for each result and view. Speeds of single rays of one thread are columns: coherent, incoherent,
    coherent_any and incoherent_any in millions per second; coherent_of_grid and so on as multiples of GRID's."""
    views = table[table.what.isin(("speed", "view")) & table["view"].notna()].drop_duplicates(["result", "view"])
    single = table[(table.what == "speed") & (table["mode"] == "single") & (table.threads == 1)]
    names = single["ray_set"].astype(str) + single["query"].map({"any": "_any"}).fillna("")
    for column, ending in (("mrays_per_second_median", ""), ("relative_to_grid_median", "_of_grid")):
        wide = single.assign(name=names + ending).pivot_table(column, ["result", "view"], "name", aggfunc="first")
        wanted = [f"{rays}{query}{ending}" for rays in RAY_SETS for query in ("", "_any")]
        views = views.merge(wide.reindex(columns=wanted).reset_index(), "left", ["result", "view"])
    return views.assign(mib=views.memory_live_bytes / 2**20)


class Data:
    """The records of a folder. table: all rows. Rows of Vulkan devices and of other machines have a different origin
    than the rows in `here`, so that only their own sections show them. full: a row for each scene, level and
    representation in the full view on the widest instruction set."""

    def __init__(self, folder, gpu=(), other_machines=()):
        rows, self.runs, self.problems = records.read(Path(folder), "here")
        for origin, where, paths in (("gpu", "a Vulkan device", gpu), ("elsewhere", "a processor", other_machines)):
            for path in map(Path, paths):
                found, _, problems = records.read(path, origin)
                found = [row for row in found if origin == "gpu" or row["origin"] == origin]
                if not problems and not any(row["origin"] == origin for row in found):
                    problems = [f"{path.name}: nothing in it was measured on {where}"]
                rows, self.problems = rows + found, self.problems + problems
        self.table = records.as_table(rows)
        self.every_view = with_speeds(self.table)
        here = self.table[(self.table.origin == "here") & (self.table.what != "skipped")]
        self.here = here[(here["speeds"] > 0) | ~here.job.astype(str).str.startswith("checks_")]
        self.isa = max(set(self.here.isa) & set(ISAS), key=ISAS.index, default="")
        self.of_isa = self.here[self.here.isa == self.isa]
        self.full = self.views("full")
        self.found = {tuple(row[key] for key in [*SAME, "view"]): row for _, row in self.views().iterrows()}

    def views(self, view=None, scene=None):
        """A row for each scene, level, representation and view; optionally only those of a view or a scene."""
        frame = self.every_view[self.every_view.result.isin(self.of_isa.result)]
        for column, value in (("view", view), ("scene", scene)):
            frame = frame if value is None else frame[frame[column] == value]
        frame = frame.sort_values(WEIGHT, kind="stable").drop_duplicates([*SAME, "view"], keep="last")
        return in_order(frame, *SAME, "view")

    def pick(self, scene, level, label, view="full"):
        """Returns the row of a representation in a view, or None."""
        return self.found.get((scene, level, label, view))

    def scenes(self):
        """Returns the scenes, the main one first: trex, or else the largest."""
        sizes = self.here.groupby("scene").quads.max().to_dict()
        return sorted(sizes, key=lambda scene: (scene != MAIN_SCENE, -sizes[scene], scene))

    def levels(self, scene):
        return sorted(set(self.here[self.here.scene == scene].level))

    def is_own(self):
        """True if all records are of the user's own cages."""
        return len(self.here) > 0 and not self.here.run_command.str.contains("--scene ", regex=False).any()

    def skipped(self, *origins):
        """Lines that list what was skipped."""
        rows = self.table[(self.table.what == "skipped") & self.table.origin.isin(origins)]
        places = zip(rows.scene, rows.level, rows.representation, rows.device, rows.skipped)
        return [f"{scene}, level {level}, {label} {device}: {why}" for scene, level, label, device, why in places]
