# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Estimates how long jobs take: from earlier runs here, or from the plan, scaled by the slowdown of those runs."""

import json

import whole_file

FILE = "job_times"  # JSON next to the records of a set; it is not a record


def key(job, levels):
    """Everything that a job's time depends on, except for the machine and the build."""
    return " ".join([job.scene, ",".join(map(str, levels)), *job.arguments])


def planned(job, levels):
    """Planned seconds for some levels of a job. Each level has four times the quads of the previous one, and the same
    number of rays."""
    return job.seconds * sum(2.5**level for level in levels) / sum(2.5**level for level in job.levels)


def read(path):
    """Returns {key: {"seconds": measured, "planned": the plan at that time}}; empty if the file is damaged."""
    try:
        times = json.loads(path.read_text(encoding="utf-8"))
        return {name: {"seconds": float(t["seconds"]), "planned": float(t["planned"])} for name, t in times.items()}
    except (OSError, ValueError, AttributeError, KeyError, TypeError):
        return {}


class Times:
    """folder: the folder of a set's records; it need not exist."""

    def __init__(self, folder):
        self.path = folder / FILE
        self.known = {}
        # entries of its own file override the others
        for path in [*sorted(folder.parent.glob("*/" + FILE)), self.path]:
            self.known.update(read(path))

    def slowdown(self):
        """Measured time of all known jobs as a multiple of their planned time; 1 without measurements."""
        total = sum(t["planned"] for t in self.known.values())
        return sum(t["seconds"] for t in self.known.values()) / total if total else 1.0

    def expected(self, job, levels):
        """Returns the seconds, and whether they were measured."""
        measurement = self.known.get(key(job, levels))
        return (measurement["seconds"], True) if measurement else (planned(job, levels) * self.slowdown(), False)

    def record(self, job, levels, seconds):
        """Records the duration of a job. All levels of the job must have been measured."""
        own = read(self.path)
        own[key(job, levels)] = {"seconds": round(seconds, 1), "planned": round(planned(job, levels), 1)}
        try:
            whole_file.write(self.path, json.dumps(own, indent=1) + "\n")
        except OSError:
            pass  # a full disk is reported when a record is written
