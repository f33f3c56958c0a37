#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures irregular meshes from packages and generated ones for docs/measurements.md: memory, builds, rays, and how
far vertices move, as cTILE, the default, and cVERT, by default and lossless, compared with Embree's default and compact
modes. Prints a table in Markdown.

    scripts/measure_meshes.py PATH/TO/cbvh_render FOLDER [--only LIST] [--json FILE]

The folder receives packages (by apt-get download and npm pack) and meshes (as OBJ), and is reused. Requires Debian's
python3-matplotlib and npm. Bytes are per triangle and exclude the application's vertices and indices.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

import numpy

from mesh_files import MESHES, write_obj
from script_arguments import existing_program

# By settings of EMBREE_CBVH, the representations and their keys in records.
RUNS = {
    "verbose": {"grid": "embree", "naive-compact": "compact", "ctile": "tile", "cvert": "vert"},
    "max_error=0,verbose": {"grid": "embree", "ctile": "lossless", "cvert": "lossless_vert"},
}


def obj_of(folder, name):
    path = folder / f"{name.replace(', ', '-').replace(' ', '_')}.obj"
    if not path.exists():
        print(f"{name}: preparing", file=sys.stderr)
        write_obj(path, MESHES[name][2](folder))
    return path


def shape_of(path):
    """Numbers of vertices and triangles, and the median length of edges."""
    vertices, triangles = [], []
    for line in path.read_text().splitlines():
        (vertices if line[0] == "v" else triangles).append(line[2:])
    positions = numpy.array(" ".join(vertices).split(), dtype=float).reshape(-1, 3)
    corners = numpy.array(" ".join(triangles).split(), dtype=int).reshape(-1, 3) - 1
    edges = positions[corners] - positions[numpy.roll(corners, 1, axis=1)]
    return len(positions), len(corners), float(numpy.median(numpy.linalg.norm(edges, axis=2)))


def render(program, path, folder, settings, options):
    record = folder / "record.json"
    command = [program, "--mesh", path, "--representation", ",".join(RUNS[settings]), "--samples", "1", "--threads"]
    command += [str(options.threads), "--output", folder / "pictures", "--json", record, "--size", options.size]
    command += ["--speed", "--rays", str(options.rays), "--repeat", str(options.repeat)]
    done = subprocess.run(
        list(map(str, command)), env={**os.environ, "EMBREE_CBVH": settings}, capture_output=True, text=True
    )
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))} failed with {done.returncode}:\n{done.stderr[-2000:]}")
    return json.loads(record.read_text())["results"]


def measure(name, options):
    """Figures of a mesh, by representation."""
    path = obj_of(options.folder, name)
    vertices, triangles, edge = shape_of(path)
    application = 12 * (vertices + triangles)  # bytes
    row = {"package": MESHES[name][0], "license": MESHES[name][1], "triangles": triangles, "median_edge": edge}
    for settings, keys in RUNS.items():
        runs = [render(options.program, path, options.folder, settings, options) for _ in range(options.rounds)]
        for i, key in enumerate(keys.values()):
            if key in row:
                continue
            results = [run[i] for run in runs]
            first = results[0]
            row[key] = {
                "bytes_per_triangle": (first["live_bytes"] - application) / triangles,
                "peak_bytes_per_triangle": (first["peak_bytes"] - application) / triangles,
                "build_seconds": statistics.median(result["build_seconds"] for result in results),
            }
            for rays in ("coherent", "incoherent"):
                for query in ("closest", "any"):
                    ratios = [result["speed"][rays][query]["relative_to_grid"] for result in results]
                    row[key][f"{rays}_{query}_relative_to_grid"] = statistics.median(ratios)
            if "compression" in first:
                row[key]["max_vertex_deviation_edges"] = first["compression"]["max_vertex_deviation"] / edge
                row[key]["compressed_share"] = 2 * first["compression"]["quads"] / triangles
                row[key]["errors"] = first["errors"]
                row[key]["any_hit_disagreements"] = first["any_hit_disagreements"]
    return row


COLUMNS = ["mesh", "thousand triangles", "bytes: Embree", "compact", "cTILE", "cVERT", "lossless", "peak"]
COLUMNS += ["build, s: Embree", "cTILE", "cVERT"]
COLUMNS += [
    rays + form for rays in ("coherent: ", "incoherent: ") for form in ("cTILE", "cVERT", "lossless", "compact")
]
COLUMNS += ["moved"]


def line_of(name, row):
    tile = row["tile"]
    cells = [name, f"{row['triangles'] / 1000:.0f}"]
    cells += [f"{row[key]['bytes_per_triangle']:.1f}" for key in ("embree", "compact")]
    cells += [f"{row[key]['bytes_per_triangle']:.2f}" for key in ("tile", "vert", "lossless")]
    cells += [f"{tile['peak_bytes_per_triangle']:.1f}"]
    cells += [f"{row[key]['build_seconds']:.3f}" for key in ("embree", "tile", "vert")]
    for rays in ("coherent", "incoherent"):
        speed = f"{rays}_closest_relative_to_grid"
        cells += [f"{row[key][speed]:.2f}" for key in ("tile", "vert", "lossless", "compact")]
    cells += [f"{tile['max_vertex_deviation_edges']:.4f}"]
    return "| " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=existing_program, help="cbvh_render")
    parser.add_argument("folder", type=Path, help="folder of packages and meshes")
    parser.add_argument(
        "--only",
        default=",".join(MESHES).replace(", ", " "),
        metavar="LIST",
        help="measure only these meshes, by their names in the table without commas (default: all)",
    )
    parser.add_argument("--size", default="512x512", metavar="WxH", help="size of the picture (default: 512x512)")
    parser.add_argument("--rays", type=int, default=0, metavar="N", help="rays in each set (default: one per pixel)")
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="speed measurements in a run (default: 5)")
    parser.add_argument("--rounds", type=int, default=1, metavar="N", help="runs; prints medians (default: 1)")
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="threads of builds (default: 1)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="file that receives all figures")
    options = parser.parse_args()
    options.folder = options.folder.resolve()
    options.folder.mkdir(parents=True, exist_ok=True)
    known = {name.replace(", ", " "): name for name in MESHES}
    wanted = options.only.split(",")
    if unknown := [name for name in wanted if name not in known]:
        parser.error(f"unknown mesh '{unknown[0]}': expected some of {', '.join(known)}")
    print("| " + " | ".join(COLUMNS) + " |\n|:--" + "|--:" * (len(COLUMNS) - 1) + "|")
    rows = {}
    for name in map(known.get, wanted):
        rows[name] = measure(name, options)
        print(line_of(name, rows[name]), flush=True)
        if options.json:
            options.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
