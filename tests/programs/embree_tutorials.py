#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Checks that Embree's own programs render compressed surfaces, selected with --rtcore, in less memory than GRID, and
that the pictures differ from GRID's by less than a limit.

    embree_tutorials.py FOLDER-OF-THE-PROGRAMS FOLDER-OF-THE-MODELS DISPLACED-CAGE-PROGRAM
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
    """Returns the color values of a picture as bytes, and the output of the program."""
    path = os.path.join(folder, "picture.ppm")
    done = subprocess.run(
        [os.path.join(PROGRAMS, program), *options, "--size", str(SIZE), str(SIZE), "--rtcore", rtcore, "-o", path],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode:
        raise SystemExit(f"FAILED: {program} --rtcore {rtcore}: {done.stdout}")
    with open(path, "rb") as file:
        values = file.read()[-3 * SIZE * SIZE :]
    os.remove(path)
    not_black = sum(1 for value in values if value) / (3 * SIZE * SIZE)
    if not_black < 0.05:
        raise SystemExit(
            f"FAILED: {program} --rtcore {rtcore}: only {not_black:.3f} of the picture is not black: "
            "expected at least 0.05"
        )
    return values, done.stdout


def difference(a, b):
    """Root mean square of a - b in 0 to 255, without values that are 0 in both."""
    squares = [(x - y) ** 2 for x, y in zip(a, b) if x or y]
    return math.sqrt(sum(squares) / max(1, len(squares)))


def mean_of_lit(values):
    """Mean of the values that are not 0."""
    lit = [x for x in values if x]
    return sum(lit) / max(1, len(lit))


def grid_bytes(output):
    """Memory of the last BVH, as Embree's allocator reports it at verbosity 2."""
    return 1e6 * float(re.findall(r"alloc : used = *([0-9.]+) MB", output)[-1])


def compressed_bytes(output):
    """Memory of compressed surfaces and their tree, which Embree's allocator does not count."""
    return 2**20 * float(re.findall(r"compression: .* quads in ([0-9.]+) MiB", output)[-1])


def require_compression(name, output):
    if "CompressedSubdivIntersector1" not in output:
        complain(f"{name}: nothing is compressed: expected all subdivision surfaces")
    if "traced by GRID" in output:
        complain(f"{name}: GRID traces some quads: expected none")


def compare(folder, program, kind, limit, *options):
    """Compares the pictures of GRID and of a representation. limit: of their difference. It is lower for cGRID, which
    stores GRID's vertices, than for cLEAF, whose thick leaves move edges of shadows."""
    grid, grid_output = draw(folder, program, "verbose=2,subdiv_accel=bvh4.grid.eager", *options)
    ours, our_output = draw(folder, program, f"verbose=2,subdiv_accel=cbvh.{kind}", *options)
    require_compression(f"{program}, {kind}", our_output)
    fraction, most = compressed_bytes(our_output) / grid_bytes(grid_output), {"leaf": 1 / 3, "grid": 3 / 4}[kind]
    if fraction > most:
        complain(f"{program}, {kind}: uses {fraction:.2f} of GRID's memory: expected at most {most:.2f}")
    d = difference(grid, ours)
    print(f"{program}, {kind}: differs by {d:.2f} of 255, {fraction:.2f} of GRID's memory")
    if d > limit:
        complain(f"{program}, {kind}: differs by {d:.2f} of 255: expected at most {limit}")


def compare_paths(folder, name, level):
    """Tests the path tracer: differences due to compression must be within the noise of the picture, and the mean
    brightness must stay within 1%."""
    samples = 16
    path = os.path.join(folder, name + ".xml")
    camera = subprocess.run(
        [DISPLACED_CAGE, name, str(level), path],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        check=True,
    ).stdout.split()
    arguments = [
        "-i",
        path,
        *camera,
        "--ambientlight",
        "0.4",
        "0.5",
        "0.6",
        "--dirlight",
        "-0.5",
        "-1",
        "-0.6",
        "1.2",
        "1.1",
        "1",
    ]
    few, _ = draw(folder, "pathtracer", "verbose=2", *arguments, "--spp", str(samples // 2))
    grid, _ = draw(folder, "pathtracer", "verbose=2", *arguments, "--spp", str(samples))
    ours, output = draw(
        folder, "pathtracer", "verbose=2,subdiv_accel=cbvh.leaf,cbvh_frame_level=0", *arguments, "--spp", str(samples)
    )
    require_compression(f"pathtracer, {name}", output)
    # The first half of the samples is the same in both pictures of GRID. Their difference therefore has the variance of
    # the picture with all samples.
    noise, d = difference(few, grid), difference(grid, ours)
    grid_mean, our_mean = mean_of_lit(grid), mean_of_lit(ours)
    print(
        f"pathtracer, {name}: noise {noise:.2f}, cLEAF differs by {d:.2f} of 255; mean {grid_mean:.2f}, "
        f"{our_mean:.2f}"
    )
    # If all paths differed, the pictures would differ by sqrt(2) times the noise.
    if d > 1.5 * noise:
        complain(f"pathtracer, {name}: differs by {d / noise:.2f} times the noise: expected at most 1.5")
    if abs(our_mean / grid_mean - 1) > 0.01:
        complain(f"pathtracer, {name}: the mean is {our_mean / grid_mean:.4f} of GRID's: expected 0.99 to 1.01")


def main():
    with tempfile.TemporaryDirectory() as folder:
        for program, limit in ("displacement_geometry", 14), ("subdivision_geometry", 4):
            compare(folder, program, "leaf", limit)
            compare(folder, program, "grid", 1.5)
        # Edge rates follow the distance, from 4 to 64, and differ between edges.
        for model, limit in ("subdiv1", 5), ("subdiv7", 6):
            view = ["-i", os.path.join(MODELS, model + ".xml"), "--vp", "1.6", "1.5", "2.2", "--vi", "0", "0", "0"]
            compare(folder, "viewer", "leaf", limit, *view)
            compare(folder, "viewer", "grid", 3, *view)  # resampled: facets differ from GRID's
        compare_paths(folder, "cube", 5)
        compare_paths(folder, "trex", 2)
        # The picture can be written, so only the setting can cause a failure.
        for setting, is_valid in ("cbvh.leaf", True), ("cbvh.leaves", False):
            done = subprocess.run(
                [
                    os.path.join(PROGRAMS, "viewer"),
                    *view,
                    "--rtcore",
                    "subdiv_accel=" + setting,
                    "--size",
                    "32",
                    "32",
                    "-o",
                    os.path.join(folder, "setting.ppm"),
                ],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                check=False,
            )
            if (done.returncode == 0) != is_valid or (not is_valid and setting not in done.stdout):
                expected = "status 0" if is_valid else "a failure that names the setting"
                complain(
                    f"viewer, subdiv_accel={setting}: status {done.returncode}, {done.stdout}: " f"expected {expected}"
                )
    print("passed" if not failures else f"{failures} failures")
    return int(failures != 0)


if __name__ == "__main__":
    sys.exit(main())
