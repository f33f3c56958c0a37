#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Compares triangle meshes in Python with Open3D's RaycastingScene, which uses Embree's triangles.

    measure_open3d.py BUILD-DIRECTORY [--rounds 9]

Prints a Markdown table: memory, and millions of rays per second on one core and on two. Requires a C compiler and
Debian 12's python3-open3d. This Open3D passes a mask of 0 and hits nothing, so a preloaded library sets masks. Open3D
and our module are in processes of their own, which trace alternately.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
VARIANTS = ("open3d", "default", "lossless")


def resident():
    with open("/proc/self/status", encoding="ascii") as status:
        return next(int(line.split()[1]) / 1024 for line in status if line.startswith("VmRSS"))


# --- a process that traces ------------------------------------------------------------


def open3d_tracer(points, triangles):
    import open3d

    scene = open3d.t.geometry.RaycastingScene()
    scene.add_triangles(open3d.core.Tensor(points), open3d.core.Tensor(triangles))

    def trace(rays):
        return scene.cast_rays(open3d.core.Tensor(rays))["t_hit"].numpy()

    return trace


def our_tracer(points, triangles, max_error):
    import embree_cbvh as cbvh

    scene = cbvh.Scene([cbvh.Mesh(points, triangles, max_error=max_error)])

    def trace(rays):
        return scene.intersect(rays[:, :3], rays[:, 3:]).t

    return trace


def work(variant, folder):
    if variant == "open3d":
        __import__("open3d")
    else:
        __import__("embree_cbvh")
    points, triangles = (np.load(f"{folder}/{name}.npy") for name in ("points", "triangles"))
    before = resident()
    if variant == "open3d":
        trace = open3d_tracer(points, triangles)
    else:
        trace = our_tracer(points, triangles, 0 if variant == "lossless" else None)
    trace(np.zeros((1, 6), np.float32))  # Open3D builds its tree at the first ray
    print(resident() - before, flush=True)
    sets = {name: np.load(f"{folder}/{name}.npy") for name in ("coherent", "random")}
    for line in sys.stdin:
        begin = time.perf_counter()
        distances = trace(sets[line.strip()])
        print(time.perf_counter() - begin, np.isfinite(distances).mean(), flush=True)


# --- the comparison --------------------------------------------------------------------


class Worker:
    def __init__(self, variant, folder, cores, environment):
        command = ["taskset", "-c", cores, sys.executable, "-B", __file__, "--work", variant, str(folder)]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1, env=environment
        )
        self.mebibytes = float(self.process.stdout.readline())

    def trace(self, name):
        print(name, file=self.process.stdin, flush=True)
        return map(float, self.process.stdout.readline().split())

    def stop(self):
        self.process.stdin.close()
        self.process.wait()


def write_inputs(folder):
    """A bumpy torus of 4.5 million triangles in shuffled order, and a million rays of each kind."""
    sys.path.append(str(ROOT / "scripts"))
    from measure_large import torus

    rng = np.random.default_rng(1)
    points, triangles = torus(1500, 1500)
    np.save(folder / "points.npy", points)
    np.save(folder / "triangles.npy", rng.permutation(triangles))
    y, x = np.mgrid[-1.5:1.5:1000j, -1.5:1.5:1000j]
    eye = np.array([0.0, -0.5, 4.0])
    directions = np.stack([x, y, 0 * x], -1).reshape(-1, 3) - eye
    coherent = np.concatenate([np.broadcast_to(eye, directions.shape), directions], -1)
    ends = rng.uniform([-1.5, -1.5, -0.5], [1.5, 1.5, 0.5], (2, len(coherent), 3))
    for name, rays in (("coherent", coherent), ("random", np.concatenate([ends[0], ends[1] - ends[0]], -1))):
        np.save(folder / f"{name}.npy", rays.astype(np.float32))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_inputs(folder)
        includes = f"-I{options.build / 'upstream/include'}"
        masks = ROOT / "tests/install/clients/open3d_masks.c"
        subprocess.run(["cc", "-shared", "-fPIC", masks, includes, "-ldl", "-o", folder / "masks.so"], check=True)
        environments = {"open3d": dict(os.environ, LD_PRELOAD=str(folder / "masks.so"))}
        ours = dict(os.environ, PYTHONPATH=str((options.build / "tutorials/python").resolve()))
        print("| cores | scene | memory, MiB | coherent | random | hits |\n|--:|:--|--:|--:|--:|--:|")
        for cores in ("0", "0,1"):
            workers = {v: Worker(v, folder, cores, environments.get(v, ours)) for v in VARIANTS}
            rates, shares = {}, {}
            for _ in range(options.rounds):
                for rays in ("coherent", "random"):
                    for variant, worker in workers.items():
                        seconds, shares[variant, rays] = worker.trace(rays)
                        rates.setdefault((variant, rays), []).append(1 / seconds)
            for variant, worker in workers.items():
                worker.stop()
                speeds = " | ".join(f"{np.median(rates[variant, rays]):.2f}" for rays in ("coherent", "random"))
                hits = ", ".join(f"{shares[variant, rays]:.4f}" for rays in ("coherent", "random"))
                print(f"| {cores.count(',') + 1} | {variant} | {worker.mebibytes:.0f} | {speeds} | {hits} |")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--work"]:
        work(*sys.argv[2:])
    else:
        main()
