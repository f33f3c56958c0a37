#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures inputs that are large for the Python module: a raster of 0.9 billion samples, and mesh files.

    measure_large.py BUILD-DIRECTORY FOLDER [raster|meshes]

Prints Markdown tables. Requires NumPy and 5 GB of disk in FOLDER, where generated files are deleted afterwards. Takes 5
minutes on two cores. Each measurement runs in a process of its own, whose peak is resident memory.
"""

import argparse
import json
import multiprocessing
import os
import resource
import struct
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
SHAPE, CELL, ORIGIN = (21600, 43200), 30.0, (4_512_345.5, 5_432_109.25)


def measured(function, *arguments):
    """Returns the result of a function in a new process, its seconds, and the peak of the process in MiB."""

    def run(connection):
        begin = time.perf_counter()
        result = function(*arguments)
        seconds = time.perf_counter() - begin
        connection.send((result, seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))

    receive, send = multiprocessing.Pipe(False)
    process = multiprocessing.get_context("fork").Process(target=run, args=(send,))
    process.start()
    send.close()
    try:
        return receive.recv()
    except EOFError:
        sys.exit(f"{function.__name__} failed")
    finally:
        process.join()


def print_row(*cells):
    print("|", " | ".join(str(cell) for cell in cells), "|", flush=True)


# --- raster ------------------------------------------------------------------------


class Raster:
    """Heights that are computed when they are read. Small ones differ from sample to sample."""

    shape = SHAPE

    def __getitem__(self, key):
        row, column = (np.arange(*part.indices(size)) for part, size in zip(key, SHAPE))
        row, column = row[:, None], column[None]
        noise = row.astype(np.uint32) * np.uint32(0x9E3779B1) ^ column.astype(np.uint32) * np.uint32(0x85EBCA77)
        noise = (noise ^ noise >> np.uint32(15)) * np.uint32(0x2C1B3C6D)
        noise = (noise ^ noise >> np.uint32(12)) / 2**32 - 0.5
        ridges = 200 * np.sin(row / 97 + column / 211) + 40 * np.sin(row / 17) * np.sin(column / 13)
        return 1500 + 900 * np.sin(row / 1700) * np.cos(column / 2300) + ridges + 6 * noise


def build_raster(path):
    import embree_cbvh as cbvh

    return cbvh.terrain(Raster(), CELL, ORIGIN, path=path).statistics()


def random_rays(terrain, count, seed):
    """From above, downwards at 45 degrees or more for most of them."""
    rng = np.random.default_rng(seed)
    column, row = rng.uniform(100, SHAPE[1] - 100, count), rng.uniform(100, SHAPE[0] - 100, count)
    directions = rng.normal(size=(count, 3))
    directions[:, 2] = -np.abs(directions[:, 2]) - 1
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    targets = np.stack([ORIGIN[0] + CELL * column, ORIGIN[1] - CELL * row, np.full(count, 1500.0)], -1)
    top = terrain.bounds[1, 2] + 10
    return targets + directions * ((top - 1500) / directions[:, 2])[:, None], directions


def trace_raster(path):
    import embree_cbvh as cbvh

    begin = time.perf_counter()
    terrain = cbvh.Terrain.load(path)
    result = {"open": time.perf_counter() - begin}
    rays = random_rays(terrain, 10**6, 1)
    terrain.intersect(*rays)  # reads the file
    for threads in (1, 2):
        begin = time.perf_counter()
        assert terrain.intersect(*rays, threads=threads).hit.all()
        result[f"random {threads}"] = len(rays[0]) / (time.perf_counter() - begin) / 1e6
    return result


def compare_raster(path, count):
    """Largest distances between hits and the exact surface: along the ray, and vertically."""
    import embree_cbvh as cbvh
    from brute_force import closest_hits, grid_triangles

    terrain, raster = cbvh.Terrain.load(path), Raster()
    origins, directions = random_rays(terrain, count, 7)
    hits, lowest = terrain.intersect(origins, directions), terrain.bounds[0, 2] - 5
    along, vertical = [], []
    for i, (o, d) in enumerate(zip(origins, directions)):
        ends = np.stack([o, o + d * ((lowest - o[2]) / d[2])])
        column, row = (ends[:, 0] - ORIGIN[0]) / CELL, (ORIGIN[1] - ends[:, 1]) / CELL
        window = [
            slice(max(int(place.min()) - 2, 0), min(int(place.max()) + 3, size))
            for place, size in zip((row, column), SHAPE)
        ]
        x, y = np.meshgrid(
            ORIGIN[0] + CELL * np.arange(window[1].start, window[1].stop),
            ORIGIN[1] - CELL * np.arange(window[0].start, window[0].stop),
        )
        triangles = grid_triangles(np.stack([x, y, raster[window]], -1) - o)
        distance = closest_hits(np.zeros((1, 3)), [d], triangles)[0][0]
        assert np.isfinite(distance) == hits.hit[i], f"ray {i}: only one of both hits"
        above = hits.position[i] - o + [0, 0, 5000]
        height = closest_hits([above], [[0.0, 0.0, -1.0]], triangles, 1e-9)[0][0]
        along.append(abs(distance - hits.t[i]))
        vertical.append(abs(height - 5000))
    return np.max(along), np.max(vertical), terrain.max_error


def measure_raster(folder):
    path = os.path.join(folder, "raster.cbvh")
    statistics, seconds, peak = measured(build_raster, path)
    print(f"{statistics['quads'] / 1e9:.2f} billion quads, {os.path.getsize(path) / 2**20:.0f} MiB in the file\n")
    print_row("step", "time, s", "peak, MiB", "random rays, million per second", "the same, two threads")
    print_row(":--", "--:", "--:", "--:", "--:")
    print_row("generate, build and save", f"{seconds:.0f}", f"{peak:.0f}", "", "")
    found, _, peak = measured(trace_raster, path)
    rates = (f"{found[f'random {threads}']:.2f}" for threads in (1, 2))
    print_row("reopen and trace", f"{found['open']:.1f}", f"{peak:.0f}", *rates)
    (along, vertical, bound), _, _ = measured(compare_raster, path, 10000)
    print(f"\n10,000 rays, largest error along the ray {along:.3f}, vertically {vertical:.3f}; max_error {bound:.3f}\n")
    os.remove(path)
    os.remove(path + ".json")


# --- mesh files ----------------------------------------------------------------------


def torus(rows, columns):
    """Vertices of a bumpy torus, and two triangles per quad."""
    v, u = (np.linspace(0, 2 * np.pi, n, endpoint=False) for n in (rows, columns))
    v, u = v[:, None], u[None]
    radius = 0.4 + 0.02 * np.sin(40 * u) * np.sin(30 * v)
    ring = 1 + radius * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), radius * np.sin(v) + 0 * u], -1).astype("<f4")
    index = np.arange(rows * columns, dtype="<u4").reshape(rows, columns)
    right, below = np.roll(index, -1, 1), np.roll(index, -1, 0)
    quads = np.stack([index, right, np.roll(below, -1, 1), below], -1).reshape(-1, 4)
    return points.reshape(-1, 3), quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def write_stl(path, points, triangles):
    with open(path, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", len(triangles)))
        for begin in range(0, len(triangles), 1 << 20):
            part = triangles[begin : begin + (1 << 20)]
            records = np.zeros(
                len(part), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("flags", "<u2")])
            )
            records["corners"] = points[part]
            records.tofile(file)


def write_ply(path, points, triangles):
    with open(path, "wb") as file:
        header = f"element vertex {len(points)}\n" + "".join(f"property float {axis}\n" for axis in "xyz")
        header += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\n"
        file.write(f"ply\nformat binary_little_endian 1.0\n{header}end_header\n".encode())
        points.tofile(file)
        records = np.empty(len(triangles), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
        records["count"], records["corners"] = 3, triangles
        records.tofile(file)


def write_obj(path, points, triangles):
    with open(path, "w", encoding="ascii") as file:
        for kind, rows in (("v %.9g %.9g %.9g\n", points), ("f %d %d %d\n", triangles + 1)):
            for begin in range(0, len(rows), 1 << 18):
                part = rows[begin : begin + (1 << 18)]
                file.write(kind * len(part) % tuple(part.ravel().tolist()))


def write_glb(path, points, triangles):
    sizes = [points.nbytes, triangles.nbytes]
    views = [{"buffer": 0, "byteOffset": offset, "byteLength": size} for offset, size in zip((0, sizes[0]), sizes)]
    bounds = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "scene": 0,
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": sum(sizes)}],
        "bufferViews": views,
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", **bounds},
            {"bufferView": 1, "componentType": 5125, "count": triangles.size, "type": "SCALAR"},
        ],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + sum(sizes), len(text), 0x4E4F534A) + text)
        file.write(struct.pack("<II", sum(sizes), 0x004E4942))
        points.tofile(file)
        triangles.tofile(file)


def read(path):
    import embree_cbvh as cbvh

    mesh = cbvh.read_mesh(path)
    return len(mesh["vertices"]), sum(len(value) for name, value in mesh.items() if name != "vertices")


def measure_meshes(folder):
    print_row("format", "million triangles", "file, MiB", "read, s", "peak, MiB")
    print_row(":--", "--:", "--:", "--:", "--:")
    for write, rows in (
        (write_stl, 2236),
        (write_ply, 2236),
        (write_obj, 2236),
        (write_glb, 2236),
        (write_stl, 6700),
        (write_ply, 10000),
    ):
        suffix = write.__name__[-3:]
        path = os.path.join(folder, "torus." + suffix)
        measured(lambda write=write, path=path, rows=rows: write(path, *torus(rows, rows)))
        counts, seconds, peak = measured(read, path)
        assert counts[0] == rows**2, f"{path}: {counts[0]} vertices"
        size = os.path.getsize(path) / 2**20
        print_row(suffix.upper(), f"{2 * rows**2 / 1e6:.0f}", f"{size:.0f}", f"{seconds:.1f}", f"{peak:.0f}")
        os.remove(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("folder")
    parser.add_argument("part", nargs="?", choices=["raster", "meshes"])
    arguments = parser.parse_args()
    sys.path += [str(arguments.build / "tutorials/python"), str(ROOT / "tests/python")]
    os.makedirs(arguments.folder, exist_ok=True)
    if arguments.part != "meshes":
        measure_raster(arguments.folder)
    if arguments.part != "raster":
        measure_meshes(arguments.folder)


if __name__ == "__main__":
    main()
