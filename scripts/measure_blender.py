#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures Blender's Cycles with Debian's Embree and with ours, and prints rows of the table in docs/measurements.md.

    scripts/measure_blender.py [--repeat N]     requires Debian 12's `blender` and a release build; takes some minutes
    scripts/measure_blender.py --interposer LIBRARY
                                                for a Blender on Embree 4, as Debian 13's and later ones

Renders scenes of scripts/blender/suzanne.py alternately with both libraries, or without and with the interposer.
scripts/blender/commit_probe.c reports Embree's memory and times. Memory excludes the geometry buffers that Blender
fills; build is the time of all commits of geometries and scenes. Embree 4 does not see the memory of libembree_cbvh,
which is therefore added as the library prints it. The pictures stay in output/blender and are compared.
"""

import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    from matplotlib.image import imread
except ModuleNotFoundError as error:
    package = "install the package python3-matplotlib"
    raise SystemExit(f"measure_blender.py: matplotlib is not installed for this Python: {package}") from error

ROOT = Path(__file__).resolve().parent.parent


SCENES = {
    "head": "subdivided, displaced head",
    "adaptive": "adaptive subdivision",
    "deforming": "deforming, 3 time steps",
    "instances": "100 instances",
    "hair": "head with hair",
}


def render(scene, preloaded, picture, settings):
    """Renders once. Returns MiB of acceleration structures, of geometry buffers, and of the process at its peak;
    seconds of all commits and of the rendering; CPU seconds of all commits and of the process. MiB of libembree_cbvh
    are counted if `settings` make it print them."""
    environment = {**os.environ, "LD_PRELOAD": ":".join(map(str, preloaded)), **settings}
    words = [
        "blender",
        "-b",
        "--python-exit-code",
        "1",
        "--python",
        ROOT / "scripts/blender/suzanne.py",
        "--",
        picture,
        scene,
    ]
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
        process = subprocess.Popen(list(map(str, words)), env=environment, stdout=output, stderr=errors)
        status, usage = os.wait4(process.pid, 0)[1:]
        output.seek(0)
        errors.seek(0)
        printed, diagnostics = output.read(), errors.read()
    commits = re.findall(r"commit: ([\d.]+) s, ([\d.]+) CPU s, (\d+) bytes, (\d+) of them buffers", diagnostics)
    took = re.search(r"^rendered: ([\d.]+) s", printed, re.MULTILINE)
    if status or not commits or not took:
        sys.exit(f"blender failed, or its Cycles does not use Embree:\n{printed[-2000:]}\n{diagnostics[-2000:]}")
    seconds, cpu_seconds, total_bytes, buffers = commits[-1]
    compressed = sum(map(float, re.findall(r"^compression: .* quads in ([\d.]+) MiB", diagnostics, re.MULTILINE)))
    return {
        "MiB": (int(total_bytes) - int(buffers)) / 2**20 + compressed,
        "buffers": int(buffers) / 2**20,
        "peak": usage.ru_maxrss / 2**10,
        "build": float(seconds),
        "build_cpu": float(cpu_seconds),
        "render": float(took[1]),
        "cpu": usage.ru_utime + usage.ru_stime,
    }


def different_pixels(one, other):
    """Returns the number of pixels that differ by more than 5% of white in any channel, and the number of all."""
    difference = abs(imread(one) - imread(other)).max(axis=-1)
    return int((difference > 0.05).sum()), difference.size


def measure(scene, repeat, ours, folder):
    """Renders a scene `repeat` times with each library. Returns the medians of stock and ours, and the numbers of
    different and of all pixels. ours: settings and libraries of our renderings."""
    measured = {"stock": [], "ours": []}
    pictures = {name: folder / f"{scene}_{name}.png" for name in measured}
    with tempfile.TemporaryDirectory() as work:
        probe = Path(work) / "commit_probe.so"
        source = ROOT / "scripts/blender/commit_probe.c"
        subprocess.run(["cc", "-shared", "-fPIC", "-O2", source, "-o", probe, "-ldl"], check=True)
        for _ in range(repeat):
            for name, (settings, more) in (("stock", ({}, [])), ("ours", ours)):
                measured[name].append(render(scene, [probe, *more], pictures[name], settings))
                print(scene, name, measured[name][-1], flush=True)
    medians = [{key: statistics.median(run[key] for run in runs) for key in runs[0]} for runs in measured.values()]
    return (*medians, *different_pixels(*pictures.values()))


def row(scene, before, after, differing, pixels):
    """Returns a row of the table."""
    cells = [
        f"{after[key]:.{digits}f} / {before[key]:.{digits}f}"
        for key, digits in (("MiB", 1), ("peak", 0), ("build_cpu", 2), ("cpu", 1))
    ]
    return " | ".join(["", SCENES[scene], *cells, f"{differing:,} of {pixels:,}", ""]).strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=3, metavar="N", help="renderings with each library (default: 3)")
    parser.add_argument(
        "--library",
        type=Path,
        default=ROOT / "build/release/embree",
        metavar="DIR",
        help="folder of our libembree3.so.3 (default: build/release/embree)",
    )
    parser.add_argument(
        "--interposer", type=Path, metavar="FILE", help="libembree_cbvh_interposer.so, for a Blender on Embree 4"
    )
    parser.add_argument(
        "--scenes",
        nargs="+",
        choices=SCENES,
        default=list(SCENES),
        metavar="NAME",
        help=f"{', '.join(SCENES)} (default: all)",
    )
    options = parser.parse_args()
    if options.interposer:
        if not options.interposer.exists():
            sys.exit(f"{options.interposer}: this file does not exist; --interposer names libembree_cbvh_interposer.so")
        ours = {"EMBREE_CBVH": "1,verbose"}, [options.interposer.resolve()]
    else:
        if not (options.library / "libembree3.so.3").exists():
            sys.exit(f"{options.library}: no libembree3.so.3 in this folder; build it first, or set --library")
        ours = {"LD_LIBRARY_PATH": str(options.library.resolve()), "EMBREE_CBVH": "1"}, []
    folder = ROOT / "output/blender"
    folder.mkdir(parents=True, exist_ok=True)
    version = subprocess.run(["blender", "--version"], capture_output=True, text=True).stdout.split()[1]
    cpu = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())[1]
    rows = [row(scene, *measure(scene, options.repeat, ours, folder)) for scene in options.scenes]
    print(f"Blender {version}, {cpu}, {os.cpu_count()} cores; ours / stock")
    print("| scene | BVH, MiB | process at its peak, MiB | commits, CPU s | process, CPU s | pixels |")
    print("|:--|--:|--:|--:|--:|--:|", *rows, sep="\n")


if __name__ == "__main__":
    main()
