# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The section of the report on scale: the herd of ten billion quads, and levels by the view. Of scripts/measure_scale.py."""

import json
from html import escape
from pathlib import Path

import report_page as p

RECORD = "scale.json"
GIB, MIB = 2**30, 2**20
MISSING = "a scene of ten billion quads: scripts/measure_scale.py, and scripts/report.py --scale with its folder"


def read(folder):
    """The record, or None."""
    path = Path(folder) / RECORD
    return json.loads(path.read_text()) if path.exists() else None


def mrays(speed, ray_set):
    return f"{speed[ray_set]['closest']['mrays_per_second']:.2f}"


def gib(count):
    return f"{count / GIB:,.1f} GiB" if count < 1000 * GIB else f"{count / GIB / 1024:,.1f} TiB"


def herd_table(herd):
    """Heads and rows: the file, and what GRID and NAIVE would take, of what they took for the copies that fitted."""
    heads = ["", "quads", "memory for all of the herd", f"quads that can be built in {gib(herd['memory'])}", "million coherent rays a second", "incoherent"]
    quads = herd["quads"]
    own = herd["renderOwnBytes"]
    rows = [["cVERT, from a file", f"{quads / 1e9:.2f} billion", f"{gib(own)}, and {gib(herd['fileBytes'])} on disk", "whatever the disk holds",
             mrays(herd["warm"]["speed"], "coherent"), mrays(herd["warm"]["speed"], "incoherent")]]  # fmt: skip
    some = herd["some"]
    rows.append([f"cVERT, {some['count']} copies from a file", f"{some['quads'] / 1e9:.2f} billion", "-", "-", mrays(some["speed"], "coherent"), mrays(some["speed"], "incoherent")])
    for other in herd["beside"]:
        each = other["bytes"] / other["quads"]
        rows.append([f"{other['representation']}, {other['count']} copies in memory", f"{other['quads'] / 1e9:.2f} billion", f"{gib(each * quads)}, reckoned from {each:.1f} bytes a quad",
                     f"{herd['memory'] / (other['peak'] / other['quads']) / 1e9:.2f} billion", mrays(other["speed"], "coherent"), mrays(other["speed"], "incoherent")])  # fmt: skip
    return heads, rows


def herd_text(herd):
    """Sentences."""
    cold, warm = herd["cold"], herd["warm"]
    rate = herd["lastQuads"] / herd["lastSeconds"] / 1e6
    stops = " and ".join(f"{'interrupted' if s['signal'] == 'SIGINT' else 'killed'} at {gib(s['bytes'])}" for s in herd["stops"])
    return [
        f"{herd['count']} T-rexes, each in a pose of its own, at level {herd['level']}: {herd['quads']:,} quads, {herd['fileBytes'] / herd['quads']:.2f} bytes each.",
        f"Built in {herd['buildSeconds'] / 60:.1f} minutes on {herd['threads']} threads, {rate:.1f} million quads a second, with {herd['ownBytes'] / MIB:,.0f} MiB of "
        f"the program's own memory at most, {herd['deviceBytes'] / MIB:,.0f} MiB of them the kernels'; {stops}, and taken up again each time.",
        f"Opened in {1e3 * cold['openSeconds']:.0f} ms with nothing of it in memory, and in {1e3 * warm['openSeconds']:.0f} ms again. A picture of {herd['size']} with "
        f"{herd['samples']} samples a pixel then takes {cold['pictureSeconds']:.1f} s the first time; rays meet {gib(herd['coldMapped'])} of the file.",
        f"In memory there are as many copies as GRID and NAIVE can build in {gib(herd['memory'])}, each larger in its picture than in that of all, and as many from a file beside them. Speeds are of one thread and single rays.",
    ]


LEVEL_HEADS = ["", "level", "million quads", "MiB", "build, s", "error to the true surface, pixels: median", "p99", "million coherent rays a second", "incoherent"]


def level_rows(levels):
    rows = []
    for row in levels:
        e = row["errors_to_true_surface"]
        rows.append([f"{row['scene']}, {row['view']}", row["level"], f"{row['quads'] / 1e6:.2f}", f"{row['live_bytes'] / MIB:.1f}", f"{row['build_seconds']:.2f}",
                     f"{e['median_pixels']:.3f}", f"{e['p99_pixels']:.3f}", mrays(row["speed"], "coherent"), mrays(row["speed"], "incoherent")])  # fmt: skip
    return rows


def markdown(record):
    lines = []

    def table(heads, rows, words):
        lines.append("| " + " | ".join(heads) + " |")
        lines.append("|" + "|".join(":--" if i < words else "--:" for i in range(len(heads))) + "|")
        lines.extend("| " + " | ".join(row) + " |" for row in rows)
        lines.append("")

    if "herd" in record:
        lines += [*herd_text(record["herd"]), ""]
        table(*herd_table(record["herd"]), 1)
    if "levels" in record:
        table(LEVEL_HEADS, level_rows(record["levels"]), 2)
    return lines


def section(folder):
    record = read(folder) if folder else None
    if not record:
        return p.section("scale", "Scale", p.missing(MISSING))
    body, commands = "", []
    if "herd" in record:
        herd = record["herd"]
        heads, rows = herd_table(herd)
        body += f"<p>{escape(' '.join(herd_text(herd)))} Measured on {escape(record['date'])}.</p>" + p.table(heads, [[escape(cell) for cell in row] for row in rows], (0, 2, 3))
        picture = Path(folder) / "picture" / herd["picture"]
        if picture.exists():
            body += p.image(picture.read_bytes(), f"{herd['quads'] / 1e9:.1f} billion quads, from a file", "many T-rexes on the move", "png")
        commands += [*herd["commands"], herd["some"]["command"]] + [other["command"] for other in herd["beside"]]
    if "levels" in record:
        body += f"<h3>Levels by the view</h3><p>Level auto gives each edge as many quads as the picture ({escape(record['levels'][0]['size'])}) needs, about one a pixel; cVERT's lattice follows it.</p>"
        body += p.table(LEVEL_HEADS, [[escape(cell) for cell in row] for row in level_rows(record["levels"])], (0, 1))
        commands += [row["command"] for row in record["levels"]]
    return p.section("scale", "Scale", body, commands=commands)
