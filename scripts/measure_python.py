#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Compares the speed of rays from Python with a C++ program that traces the same rays of the same arrays.

    ninja -C build/release embree_cbvh cbvh_ray_arrays
    scripts/measure_python.py build/release [--rounds 9]

The scene is the trex at level 5, saved and loaded by both. Each set has about a million rays: primary rays in tiles,
their bounces, and rays between random points of the scene's box. Python and C++ trace alternately. The table has
medians in millions of rays per second: by wall-clock time, and, as other programs may run, by processor time of all
threads.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np


def ray_sets(cbvh, scene):
    """Arrays of origins and directions by the name of their set."""
    primary = cbvh.coherent_rays(scene.camera("full", (1024, 1024)))
    hits = scene.intersect(*primary)
    lower, upper = scene.bounds
    offset = 1e-4 * float(np.linalg.norm(upper - lower))
    first, second = np.random.default_rng(1).uniform(lower, upper, (2, 1 << 20, 3)).astype(np.float32)
    return {
        "primary": primary,
        "bounces": cbvh.bounce_rays(hits, *primary, offset=offset),
        "random": (first, second - first),
    }


class Program:
    """cbvh_ray_arrays with a scene and a set of rays."""

    def __init__(self, path, scene, rays, folder):
        file = folder / "rays"
        file.write_bytes(b"".join(np.ascontiguousarray(array).tobytes() for array in rays))
        self.process = subprocess.Popen(
            [path, scene, file], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )

    def seconds(self, query, threads):
        """Wall-clock and processor time."""
        self.process.stdin.write(f"{query} {threads}\n")
        return [float(word) for word in self.process.stdout.readline().split()]

    def end(self):
        self.process.stdin.close()
        self.process.wait()


def seconds_of_python(scene, rays, query, threads):
    """Wall-clock and processor time."""
    call = scene.intersect if query == "closest" else scene.occluded
    wall, processor = time.perf_counter(), time.process_time()
    call(*rays, threads=threads)
    return time.perf_counter() - wall, time.process_time() - processor


def measure(scene, rays, program, rounds):
    """Medians in seconds of (Python, C++) by query and number of threads: [wall-clock, processor] each."""
    cases = [(query, threads) for query in ("closest", "any") for threads in (1, 2)]
    times = {case: ([], []) for case in cases}
    for _ in range(rounds):
        for case in cases:
            times[case][0].append(seconds_of_python(scene, rays, *case))
            times[case][1].append(program.seconds(*case))
    return {case: [np.median(side, axis=0) for side in both] for case, both in times.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path, help="build folder")
    parser.add_argument("--rounds", type=int, default=9)
    arguments = parser.parse_args()
    sys.path.insert(0, str(arguments.build / "tutorials/python"))
    import embree_cbvh as cbvh

    print("| rays | query | threads | Python | C++ | ratio | Python, CPU | C++, CPU | ratio |")
    print("|:--|:--|--:|--:|--:|--:|--:|--:|--:|")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cbvh.build(cbvh.Model.generate("trex"), "ctile", 5).save(folder / "scene")
        scene = cbvh.load(folder / "scene")
        for rays_name, rays in ray_sets(cbvh, scene).items():
            program = Program(arguments.build / "tutorials/measure/cbvh_ray_arrays", folder / "scene", rays, folder)
            for (query, threads), times in measure(scene, rays, program, arguments.rounds).items():
                python, cpp = (1e-6 * len(rays[0]) / seconds for seconds in times)
                rates = " | ".join(f"{p:.2f} | {c:.2f} | {p / c:.2f}" for p, c in zip(python, cpp))
                print(f"| {rays_name} | {query} | {threads} | {rates} |", flush=True)
            program.end()


if __name__ == "__main__":
    main()
