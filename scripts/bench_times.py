# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""How long jobs take: as long as they took here, or by the plan at the pace of what was measured here."""

import json

import whole_file

FILE = "job_times"  # JSON beside the records of a set, and none of them


def key(job, levels):
    """All that a job's time depends on, but for the machine and the build."""
    return " ".join([job.scene, ",".join(map(str, levels)), *job.arguments])


def planned(job, levels):
    """Seconds for some of a job's levels: each has four times the quads of the last, and as many rays."""
    return job.seconds * sum(2.5**level for level in levels) / sum(2.5**level for level in job.levels)


def read(path):
    """{key: {"seconds": measured, "planned": by the plan of then}}; nothing of a file that is damaged."""
    try:
        times = json.loads(path.read_text(encoding="utf-8"))
        return {name: {"seconds": float(t["seconds"]), "planned": float(t["planned"])} for name, t in times.items()}
    except (OSError, ValueError, AttributeError, KeyError, TypeError):
        return {}


class Times:
    """folder: of a set's records, whether it is there or not."""

    def __init__(self, folder):
        self.path = folder / FILE
        self.known = {}
        for path in [*sorted(folder.parent.glob("*/" + FILE)), self.path]:  # its own count most
            self.known.update(read(path))

    def pace(self):
        """How many times as long as planned jobs took here; 1 where none was measured."""
        total = sum(t["planned"] for t in self.known.values())
        return sum(t["seconds"] for t in self.known.values()) / total if total else 1.0

    def expected(self, job, levels):
        """Seconds, and whether they were measured."""
        found = self.known.get(key(job, levels))
        return (found["seconds"], True) if found else (planned(job, levels) * self.pace(), False)

    def note(self, job, levels, seconds):
        """Of a job that was measured, all of it."""
        own = read(self.path)
        own[key(job, levels)] = {"seconds": round(seconds, 1), "planned": round(planned(job, levels), 1)}
        try:
            whole_file.write(self.path, json.dumps(own, indent=1) + "\n")
        except OSError:
            pass  # a record that finds no room is reported
