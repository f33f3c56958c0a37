#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""A compressed mesh casts few shadows on itself in Blender, and none if it is lossless.

    blender_shadows.py BLENDER LIBRARY [--interposer FILE] [--samples N] [--edge LENGTH] [--keep FOLDER]

LIBRARY is the folder of our libembree3.so.3. If Blender loads Embree 4, the test runs with the interposer instead.
Cycles shades points of the triangles that Blender keeps, but its shadow rays hit the triangles that Embree stores. If
compression moves them, a shadow ray that starts next to an edge may hit the neighbor of its triangle ("shadow acne",
dark dashes along edges). The share of such rays is proportional to the spacing of the lattice.

The test renders bumpy_sheet.py with several spacings and compares each picture with one that is not compressed. It
requires:
 - The default and 1/2048 of an edge darken at most MOST_DARK pixels by more than 5%, and none by more than
   MOST_DARKENING.
 - Lossless compression darkens no pixel by more than 5%. Neither does another build of Embree, if the system has one.
 - 1/36 of an edge darkens at least 100 times MOST_DARK pixels. Otherwise the scene does not show the effect.
 - No spacing brightens a pixel by more than 5%: no light leaks.

The limits hold for the default options. With fewer samples each shadowed ray darkens its pixel by more.

Exits with 77 if Blender is missing, if its Cycles loads no Embree, or if it loads Embree 4 and no interposer is given.
"""

import argparse
import array
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SCENE = Path(__file__).resolve().parent / "bumpy_sheet.py"
SKIP = 77
# Limit of dark pixels, of 230400. 1/512 of an edge darkens 2055 by up to 17%, 1/36 darkens 49693 by up to 80%.
MOST_DARK = 400
MOST_DARKENING = 0.15
COMPRESSIONS = ["default", "36", "512", "2048", "lossless"]
failures = 0


def complain(text):
    global failures
    failures += 1
    print("FAILED:", text)


def skip(reason):
    print("skipped:", reason)
    sys.exit(SKIP)


class Picture:
    """A picture as floats, with the seconds that its render took and the library's line about it."""

    def __init__(self, path, log):
        self.pixels = array.array("f", path.read_bytes())
        self.seconds = float(re.search(r"^end: ([\d.]+) s", log, re.MULTILINE)[1])
        self.line = " ".join(re.findall(r"^compression: .*", log, re.MULTILINE))
        blocks = re.search(r"in ([\d.]+) MiB", self.line)
        self.mebibytes = float(blocks[1]) if blocks else None

    def compare(self, plain):
        """Pixels darker by more than 5%, pixels brighter by more than 5%, the largest difference, and the mean one."""
        differences = [b / a - 1 for a, b in zip(plain.pixels, self.pixels)]
        sizes = [abs(d) for d in differences]
        dark, bright = sum(d < -0.05 for d in differences), sum(d > 0.05 for d in differences)
        return dark, bright, max(sizes), sum(sizes) / len(sizes)


def render(options, folder, settings, compressions):
    """A picture for each compression, and the paths of the Embree libraries and the interposer that Blender loaded."""
    environment = {name: value for name, value in os.environ.items() if name not in ("EMBREE_CBVH", "LD_LIBRARY_PATH")}
    folder.mkdir(parents=True, exist_ok=True)
    words = [
        options.blender,
        "-b",
        "--python-exit-code",
        "1",
        "--python",
        SCENE,
        "--",
        folder,
        options.samples,
        options.edge,
        *compressions,
    ]
    words = [str(word) for word in words]
    done = subprocess.run(words, env={**environment, **settings}, capture_output=True, text=True, check=False)
    loaded = re.search(r"^libraries: *(.*)", done.stderr, re.MULTILINE)
    if done.returncode or not loaded:
        raise SystemExit(f"FAILED: blender exits with {done.returncode}:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
    logs = done.stderr.split("begin: ")[1:]
    pictures = [Picture(folder / f"{name}.floats", log) for name, log in zip(compressions, logs)]
    return pictures, [Path(path).resolve() for path in loaded[1].split()]


def check(options, folder):
    (system,), libraries = render(options, folder / "system", {}, ["plain"])
    if not libraries:
        skip("Blender's Cycles does not load Embree")
    system_library = libraries[0]
    if system_library.name.startswith("libembree3."):
        ours, settings = options.library, {"LD_LIBRARY_PATH": str(options.library)}
        runs = [["plain", *COMPRESSIONS]]
    elif options.interposer:
        ours, settings = options.interposer.parent, {"LD_PRELOAD": str(options.interposer)}
        runs = [[compression] for compression in ["plain", *COMPRESSIONS]]
    else:
        skip(f"Blender's Cycles loads {system_library}, and there is no interposer")
    pictures = []
    for compressions in runs:
        more, loaded = render(options, folder / "ours", settings, compressions)
        pictures += more
        if ours not in [path.parent for path in loaded]:
            raise SystemExit(f"FAILED: Blender loads {', '.join(map(str, loaded))}, none of them in {ours}")
    plain, *pictures = pictures
    if plain.line or system.line:
        complain("the picture to compare with is compressed")
    print(f"{options.samples} samples per pixel, {len(plain.pixels)} pixels")
    print("| spacing | darker by > 5% | brighter by > 5% | largest | mean | MiB of blocks | render |")
    print("|:--|--:|--:|--:|--:|--:|--:|")
    names = [f"edge/{name}" if name.isdigit() else name for name in COMPRESSIONS]
    rows = list(zip(names, pictures))
    system_name = f"not compressed, {system_library}"
    dark = {}
    for name, picture in [("not compressed", plain), (system_name, system), *rows]:
        dark[name], bright, largest, mean = picture.compare(plain)
        blocks = "" if picture.mebibytes is None else f"{picture.mebibytes:.2f}"
        print(
            f"| {name} | {dark[name]} | {bright} | {100 * largest:.2f}% | {100 * mean:.4f}% | {blocks} "
            f"| {picture.seconds:.1f} s |"
        )
        if bright:
            complain(f"{name}: {bright} pixels are brighter by more than 5%, none may be")
        if name in ("default", "edge/2048") and largest > MOST_DARKENING:
            complain(f"{name}: a pixel differs by {100 * largest:.0f}%, more than {100 * MOST_DARKENING:.0f}%")
    for name, picture in rows:
        print(f"{name}: {picture.line}")
        if not re.search(r"1 triangle mesh as cTILE: 1000000 quads", picture.line):
            complain(f"{name}: the sheet is not compressed as 1000000 quads")
    for name, most in {"default": MOST_DARK, "edge/2048": MOST_DARK, "lossless": 0, system_name: 0}.items():
        if dark[name] > most:
            complain(f"{name}: {dark[name]} pixels are darker by more than 5%, at most {most} may be")
    if dark["edge/36"] < 100 * MOST_DARK:
        complain(
            f"edge/36: {dark['edge/36']} pixels are darker by more than 5%, at least {100 * MOST_DARK} should be: "
            "the scene does not show the effect"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("blender")
    parser.add_argument("library", type=lambda text: Path(text).resolve(), help="folder of our libembree3.so.3")
    parser.add_argument("--interposer", type=lambda text: Path(text).resolve(), help="for a Blender on Embree 4")
    parser.add_argument("--samples", type=int, default=32, help="samples per pixel (default: %(default)s)")
    # Spacings are rounded down to a power of two: 1/36 of this edge is hardly rounded, 1/2048 becomes 1/2312.
    parser.add_argument("--edge", type=float, default=0.0088, help="edge length of the quads (default: %(default)s)")
    parser.add_argument("--keep", type=Path, help="folder that the pictures are written to")
    options = parser.parse_args()
    if not shutil.which(options.blender):
        skip("no blender, install the package blender")
    if options.keep:
        check(options, options.keep.resolve())
    else:
        with tempfile.TemporaryDirectory() as folder:
            check(options, Path(folder))
    print("passed" if not failures else f"{failures} failures")
    return int(failures != 0)


if __name__ == "__main__":
    sys.exit(main())
