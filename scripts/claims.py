#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Measures on all generated scenes how much smaller cVERT and cGRID are than GRID, and how many pixels differ in cVERT
(docs/error.md).

    scripts/claims.py                            all scenes: some minutes on two cores, and 7 GB for the largest NAIVE
    scripts/claims.py --scene cube,rough         only these; rough is trex with five times the displacement
    scripts/claims.py --cage body.obj --height skin.png    a cage of your own

A pixel differs if one of its colors differs from GRID's by more than 5% (or 25%) of white, in shaded pictures at level
6. NAIVE has GRID's triangles and differs only by rounding.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    from matplotlib.image import imread
except ModuleNotFoundError as error:
    package = "install the package python3-matplotlib"
    raise SystemExit(f"claims.py: matplotlib is not installed for this Python: {package}") from error
from reporting.formats import Table
from script_arguments import existing_program

ROOT = Path(__file__).resolve().parent.parent
LEVELS = (4, 5, 6)
SIZE = "500x500"
SAMPLES = (1, 16)
DIFFERENCES = (0.05, 0.25)
KINDS = ("cVERT", "cGRID")

MODELS = {name: ["--scene", name] for name in ("cube", "frog", "knee", "scythe", "trex")}
MODELS["rough"] = ["--scene", "trex", "--rough"]


def run(options, model, folder, *words):
    """Runs cbvh_render. Returns its results by representation."""
    path = Path(folder) / "numbers.json"
    command = [
        options.render,
        *model,
        "--true-surface",
        "0",
        "--size",
        SIZE,
        "--output",
        folder,
        "--json",
        path,
        *words,
    ]
    if subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL).returncode != 0:
        raise SystemExit("claims.py: cbvh_render failed, see its message above")
    return {r["representation"]: r for r in json.loads(path.read_text(encoding="utf-8"))["results"]}


def differing_pixels(folder, one, other):
    """Number of pixels that differ by more than each of DIFFERENCES."""
    pictures = [imread(next(Path(folder).glob(f"*_{name}.png")))[..., :3] for name in (one, other)]
    difference = abs(pictures[0] - pictures[1]).max(axis=-1)
    return [int((difference > d).sum()) for d in DIFFERENCES]


def measure(options, model):
    """Returns ratios of bytes by kind and level; differing pixels of NAIVE and cVERT for each number of samples; pixels
    that show the surface."""
    ratios, pixels = {}, {}
    for level in LEVELS:
        for samples in SAMPLES if level == LEVELS[-1] else SAMPLES[:1]:
            kinds = (
                "grid,cvert" + (",cgrid" if samples == SAMPLES[0] else "") + (",naive" if level == LEVELS[-1] else "")
            )
            with tempfile.TemporaryDirectory() as folder:
                results = run(options, model, folder, "--level", level, "--representation", kinds, "--samples", samples)
                for kind in KINDS:
                    if kind in results:
                        ratios[kind, level] = results["GRID"]["live_bytes"] / results[kind]["live_bytes"]
                hits = results["cVERT"]["errors"]["both_hit"]
                if level == LEVELS[-1]:
                    for kind in ("naive", "cvert"):
                        pixels[kind, samples] = (
                            differing_pixels(folder, "grid", kind) if kind.upper() in map(str.upper, results) else None
                        )
    return ratios, pixels, hits


def counts(values):
    return "-" if values is None else " ".join(map(str, values))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--render",
        type=existing_program,
        default=str(ROOT / "build/release/tutorials/render/cbvh_render"),
        metavar="PROGRAM",
        help="cbvh_render (default: build/release/tutorials/render/cbvh_render)",
    )
    parser.add_argument(
        "--scene",
        metavar="LIST",
        default=",".join(MODELS),
        help=f"comma-separated list of scenes to measure: {', '.join(sorted(MODELS))} (default: all)",
    )
    parser.add_argument("--cage", metavar="FILE", help="measure this OBJ instead of the scenes")
    parser.add_argument("--height", metavar="FILE", help="height map of the cage (default: none)")
    options = parser.parse_args()
    scenes = options.scene.split(",")
    for name in scenes:
        if name not in MODELS:
            parser.error(f"unknown scene '{name}': expected {', '.join(sorted(MODELS))}")
    models = {name: MODELS[name] for name in scenes}
    if options.cage:
        models = {
            Path(options.cage).stem: ["--cage", options.cage, *(["--height", options.height] if options.height else [])]
        }
    rows, all_ratios = [], {(kind, level): [] for kind in KINDS for level in LEVELS}
    for name, model in models.items():
        ratios, pixels, hits = measure(options, model)
        for key in all_ratios:
            all_ratios[key].append(ratios[key])
        cells = [counts(pixels[kind, samples]) for samples in SAMPLES for kind in ("naive", "cvert")]
        rows.append([name, *(f"{ratios['cVERT', level]:.1f}" for level in LEVELS), str(hits), *cells])
        print(" ".join(rows[-1]), file=sys.stderr)  # a result even if the next scene is interrupted
    heads = [
        "",
        *(f"level {level}" for level in LEVELS),
        "pixels",
        *(f"{kind}, {n}" for n in ("1 sample", "16 samples") for kind in ("NAIVE", "cVERT")),
    ]
    print(Table(heads, rows).markdown())
    for (kind, level), values in all_ratios.items():
        print(f"{kind}, level {level}: {min(values):.1f} to {max(values):.1f} times smaller than GRID")


if __name__ == "__main__":
    main()
