#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Checks that Embree's own programs render the same pictures with compressed surfaces, selected with --rtcore, as
with GRID.

    embree_tutorials.py FOLDER-OF-THE-PROGRAMS MODELS DISPLACED-CAGE-PROGRAM
"""

import math
import os
import re
import subprocess
import sys
import tempfile

PROGRAMS, MODELS, DISPLACED_CAGE = sys.argv[1:4]
SIZE = 256
failures = 0


def complain(text):
    global failures
    failures += 1
    print("FAILED:", text)


def draw(folder, program, rtcore, *options):
    """Returns the pixels of a picture as bytes, and the output of the program."""
    path = os.path.join(folder, "picture.ppm")
    done = subprocess.run(
        [os.path.join(PROGRAMS, program), *options, "--size", str(SIZE), str(SIZE), "--rtcore", rtcore, "-o", path],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"FAILED: {program} --rtcore {rtcore}: {done.stdout}")
    with open(path, "rb") as file:
        pixels = file.read()[-3 * SIZE * SIZE:]
    os.remove(path)
    return pixels, done.stdout


def difference(a, b):
    """Root mean square of a - b in 0 to 255, over pixels that are not black in both."""
    squares = [(x - y) ** 2 for x, y in zip(a, b) if x or y]
    return math.sqrt(sum(squares) / max(1, len(squares)))


def mean(pixels):
    lit = [x for x in pixels if x]
    return sum(lit) / max(1, len(lit))


def megabytes(said):
    """Memory of the last BVH, as reported at verbosity 2."""
    return float(re.findall(r"alloc : used = *([0-9.]+) MB", said)[-1])


def compare(folder, program, kind, limit, *options):
    # cGRID has GRID's vertices. cLEAF has thick leaves, which move edges of shadows.
    grid, grid_said = draw(folder, program, "verbose=2,subdiv_accel=bvh4.grid.eager", *options)
    ours, said = draw(folder, program, f"verbose=2,subdiv_accel=cbvh.{kind}", *options)
    if "CompressedSubdivIntersector1" not in said:
        complain(f"{program}, {kind}: nothing is compressed")
    if "traced by GRID" in said:
        complain(f"{program}, {kind}: GRID traces some of it")
    part = megabytes(said) / megabytes(grid_said)
    if part > {"leaf": 1 / 3, "grid": 3 / 4}[kind]:
        complain(f"{program}, {kind}: uses {part:.2f} of GRID's memory")
    d = difference(grid, ours)
    print(f"{program}, {kind}: differs by {d:.2f} of 255, {part:.2f} of GRID's memory")
    if d > limit:
        complain(f"{program}, {kind}: differs by {d:.2f}, more than {limit}")


def compare_paths(folder, name, level):
    """Tests the path tracer: differences due to compression must be within the noise of the picture, and the mean
    brightness must not change."""
    samples = 16
    path = os.path.join(folder, name + ".xml")
    camera = subprocess.run([DISPLACED_CAGE, name, str(level), path], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                            text=True, check=True).stdout.split()
    arguments = ["-i", path, *camera, "--ambientlight", "0.4", "0.5", "0.6", "--dirlight", "-0.5", "-1", "-0.6", "1.2",
                 "1.1", "1"]
    setting = "verbose=2,subdiv_accel={},cbvh_frame_level=0"
    few, _ = draw(folder, "pathtracer", "verbose=2", *arguments, "--spp", str(samples // 2))
    grid, _ = draw(folder, "pathtracer", "verbose=2", *arguments, "--spp", str(samples))
    ours, said = draw(folder, "pathtracer", setting.format("cbvh.leaf"), *arguments, "--spp", str(samples))
    if "CompressedSubdivIntersector1" not in said or "traced by GRID" in said:
        complain(f"pathtracer, {name}: not all of it is compressed")
    # Pictures with half the samples: their difference has the variance of the other picture.
    noise, d = difference(few, grid), difference(grid, ours)
    print(f"pathtracer, {name}: noise {noise:.2f}, cLEAF differs by {d:.2f} of 255; mean {mean(grid):.2f}, "
          f"{mean(ours):.2f}")
    if d > 1.5 * noise: # different paths: at most sqrt(2)
        complain(f"pathtracer, {name}: differs by more than its noise")
    if abs(mean(ours) / mean(grid) - 1) > 0.01:
        complain(f"pathtracer, {name}: the mean brightness changes")


def main():
    with tempfile.TemporaryDirectory() as folder:
        for program, limit in ("displacement_geometry", 14), ("subdivision_geometry", 4):
            compare(folder, program, "leaf", limit)
            compare(folder, program, "grid", 1.5)
        # Edge rates follow the distance, from 4 to 64, and differ between edges.
        for model, limit in ("subdiv1", 5), ("subdiv7", 6):
            near = ["-i", os.path.join(MODELS, model + ".xml"), "--vp", "1.6", "1.5", "2.2", "--vi", "0", "0", "0"]
            compare(folder, "viewer", "leaf", limit, *near)
            compare(folder, "viewer", "grid", 3, *near) # resampled: facets differ from GRID's
        compare_paths(folder, "cube", 5)
        compare_paths(folder, "trex", 2)
        done = subprocess.run([os.path.join(PROGRAMS, "viewer"), *near, "--rtcore", "subdiv_accel=cbvh.leaves", "-o",
                               "/dev/null"],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode == 0 or "cbvh.leaves" not in done.stdout:
            complain(f"an invalid setting: status {done.returncode}, {done.stdout}")
    print("passed" if not failures else f"{failures} failures")
    return int(failures != 0)


if __name__ == "__main__":
    sys.exit(main())
