#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures what Blender's Cycles takes with Debian's Embree and with ours, and writes the sentence into README.md.

    scripts/measure_blender.py [--rounds N]     needs Debian 12's `blender` and a built release, some minutes

Renders scripts/blender/suzanne.py with both libraries in turns, and asks Embree through scripts/blender/commit_probe.c:
memory is what all commits allocate, without the geometry buffers that Blender fills; build is the time of all commits. The
pictures stay in output/blender and are compared.
"""

import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- begin: scripts/measure_blender.py -->\n", "<!-- end -->\n"
OURS = {"LD_LIBRARY_PATH": str(ROOT / "build/release/embree"), "EMBREE_CBVH": "1"}


def render(probe, picture, settings):
    """One render: MiB of all commits and with the geometry buffers, seconds of all commits and of the render."""
    environment = {**os.environ, "LD_PRELOAD": str(probe), **settings}
    words = ["blender", "-b", "--python-exit-code", "1", "--python", ROOT / "scripts/blender/suzanne.py", "--", picture]
    done = subprocess.run(list(map(str, words)), env=environment, capture_output=True, text=True)
    commits = re.findall(r"commit: ([\d.]+) s, (-?\d+) bytes more, (\d+) bytes in all", done.stderr)
    took = re.search(r"Time: (\d+):([\d.]+)", done.stdout)
    if done.returncode or not commits or not took:
        sys.exit(f"blender failed, or its Cycles is without Embree:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
    return {
        "MiB": sum(int(more) for _, more, _ in commits) / 2**20,
        "with buffers": int(commits[-1][2]) / 2**20,
        "build": sum(float(seconds) for seconds, _, _ in commits),
        "render": 60 * int(took[1]) + float(took[2]),
    }


def different_pixels(one, other):
    """Pixels of two pictures that differ by more than 5% of full white, and all pixels."""
    done = subprocess.run(["idiff", "-fail", "0.05", "-failpercent", "100", one, other], capture_output=True, text=True)
    found = re.search(r"(\d+) pixels \([^)]*\) over 0.05", done.stdout)
    return int(found[1]) if found else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    folder = ROOT / "output/blender"
    folder.mkdir(parents=True, exist_ok=True)
    measured = {"stock": [], "ours": []}
    with tempfile.TemporaryDirectory() as work:
        probe = Path(work) / "commit_probe.so"
        subprocess.run(["cc", "-shared", "-fPIC", "-O2", ROOT / "scripts/blender/commit_probe.c", "-o", probe, "-ldl"], check=True)
        for _ in range(options.rounds):
            for name, settings in (("stock", {}), ("ours", OURS)):
                measured[name].append(render(probe, folder / f"{name}.png", settings))
                print(name, measured[name][-1], flush=True)
    stock, ours = ({key: statistics.median(run[key] for run in runs) for key in runs[0]} for runs in measured.values())
    version = subprocess.run(["blender", "--version"], capture_output=True, text=True).stdout.split()[1]
    cpu = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())[1]
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    text = (
        f"Blender {version} then renders a subdivided and displaced head of 4 million triangles from {ours['MiB']:.0f} MiB instead\n"
        f"of {stock['MiB']:.0f}, and builds its BVH in {ours['build']:.2f} s instead of {stock['build']:.1f} "
        f"(`scripts/measure_blender.py`, {cpu}, {os.cpu_count()} cores,\ncommit {commit}).\n"
    )
    print(f"{text}render {ours['render']:.1f} s instead of {stock['render']:.1f}; "
          f"{different_pixels(folder / 'stock.png', folder / 'ours.png')} of 614400 pixels differ by more than 5%")
    page = ROOT / "README.md"
    before, rest = page.read_text().split(BEGIN)
    page.write_text(f"{before}{BEGIN}\n{text}\n{END}{rest.split(END, 1)[1]}")


if __name__ == "__main__":
    main()
