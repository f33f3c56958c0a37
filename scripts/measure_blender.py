#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures Blender's Cycles with Debian's Embree and with ours, and writes the result into README.md.

    scripts/measure_blender.py [--repeat N]     requires Debian 12's `blender` and a release build; takes some minutes
    scripts/measure_blender.py --interposer LIBRARY    for a Blender on Embree 4, as Debian 13's and later ones;
                                                       README.md stays as is

Renders scripts/blender/suzanne.py alternately with both libraries, or without and with the interposer.
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
import textwrap
from pathlib import Path

try:
    from matplotlib.image import imread
except ModuleNotFoundError as error:
    package = "install the package python3-matplotlib"
    raise SystemExit(f"measure_blender.py: matplotlib is not installed for this Python: {package}") from error

ROOT = Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- begin: scripts/measure_blender.py -->\n", "<!-- end -->\n"


def render(preloaded, picture, settings):
    """Renders once. Returns MiB of acceleration structures and of geometry buffers, and seconds of all commits and of
    the rendering. MiB of libembree_cbvh are counted if `settings` make it print them."""
    environment = {**os.environ, "LD_PRELOAD": ":".join(map(str, preloaded)), **settings}
    words = ["blender", "-b", "--python-exit-code", "1", "--python", ROOT / "scripts/blender/suzanne.py", "--", picture]
    done = subprocess.run(list(map(str, words)), env=environment, capture_output=True, text=True)
    commits = re.findall(r"commit: ([\d.]+) s, (\d+) bytes, (\d+) of them buffers", done.stderr)
    took = re.search(r"^rendered: ([\d.]+) s", done.stdout, re.MULTILINE)
    if done.returncode or not commits or not took:
        sys.exit(f"blender failed, or its Cycles does not use Embree:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
    seconds, total_bytes, buffers = commits[-1]
    compressed = sum(map(float, re.findall(r"^compression: .* quads in ([\d.]+) MiB", done.stderr, re.MULTILINE)))
    return {
        "MiB": (int(total_bytes) - int(buffers)) / 2**20 + compressed,
        "buffers": int(buffers) / 2**20,
        "build": float(seconds),
        "render": float(took[1]),
    }


def different_pixels(one, other):
    """Number of pixels that differ by more than 5% of white in any channel."""
    difference = abs(imread(one) - imread(other))
    return int((difference.max(axis=-1) > 0.05).sum())


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
    options = parser.parse_args()
    preloaded = []
    if options.interposer:
        if not options.interposer.exists():
            sys.exit(f"{options.interposer}: this file does not exist; --interposer names libembree_cbvh_interposer.so")
        our_settings = {"EMBREE_CBVH": "1,verbose"}
        preloaded = [options.interposer.resolve()]
    else:
        if not (options.library / "libembree3.so.3").exists():
            sys.exit(f"{options.library}: no libembree3.so.3 in this folder; build it first, or set --library")
        our_settings = {"LD_LIBRARY_PATH": str(options.library.resolve()), "EMBREE_CBVH": "1"}
    folder = ROOT / "output/blender"
    folder.mkdir(parents=True, exist_ok=True)
    measured = {"stock": [], "ours": []}
    with tempfile.TemporaryDirectory() as work:
        probe = Path(work) / "commit_probe.so"
        subprocess.run(
            ["cc", "-shared", "-fPIC", "-O2", ROOT / "scripts/blender/commit_probe.c", "-o", probe, "-ldl"], check=True
        )
        for _ in range(options.repeat):
            for name, settings, more in (("stock", {}, []), ("ours", our_settings, preloaded)):
                measured[name].append(render([probe, *more], folder / f"{name}.png", settings))
                print(name, measured[name][-1], flush=True)
    before, after = (
        {key: statistics.median(run[key] for run in runs) for key in runs[0]} for runs in measured.values()
    )
    version = subprocess.run(["blender", "--version"], capture_output=True, text=True).stdout.split()[1]
    cpu = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())[1]
    rendering = (
        f"render {after['render']:.1f} s instead of {before['render']:.1f}; "
        f"{different_pixels(folder / 'stock.png', folder / 'ours.png')} of 614400 pixels differ by more than 5%"
    )
    if options.interposer:
        print(
            f"Blender {version}, {cpu}: {after['MiB']:.1f} MiB instead of {before['MiB']:.1f}, "
            f"built in {after['build']:.2f} s instead of {before['build']:.2f}; {rendering}"
        )
        return
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True
    ).stdout.strip()
    text = (
        f"Blender {version} then renders a subdivided and displaced head of 4 million triangles with an acceleration"
        f" structure of {after['MiB']:.0f} MiB instead of {before['MiB']:.0f}, built in {after['build']:.2f} s instead"
        f" of {before['build']:.1f}. Blender's own vertex and index buffers ({before['buffers']:.0f} MiB) stay."
        f" (`scripts/measure_blender.py`, {cpu}, {os.cpu_count()} cores, commit {commit})"
    )
    text = "\n".join(textwrap.wrap(text, 116, break_long_words=False, break_on_hyphens=False)) + "\n"
    print(f"{text}{rendering}")
    page = ROOT / "README.md"
    head, rest = page.read_text().split(BEGIN)
    page.write_text(f"{head}{BEGIN}\n{text}\n{END}{rest.split(END, 1)[1]}")


if __name__ == "__main__":
    main()
