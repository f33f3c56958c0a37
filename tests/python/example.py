#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""The example runs from the first cell to the last, on a smaller scene, and makes its pictures.

usage: example.py COMPARE-REPRESENTATIONS.PY"""

import os
import re
import sys
import tempfile

import matplotlib.pyplot as plt

EXAMPLE = sys.argv[1]
SMALLER = {"SCENE": '"cube"', "LEVELS": "(3, 4)", "SIZE": "(96, 72)", "ROUNDS": "1"}

with open(EXAMPLE, encoding="utf-8") as file:
    code = file.read()
for name, value in SMALLER.items():
    code, count = re.subn(rf"^{name} = .*$", f"{name} = {value}", code, flags=re.MULTILINE)
    assert count == 1, name

with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    names = {"__name__": "__main__"}
    exec(compile(code, EXAMPLE, "exec"), names)  # pylint: disable=exec-used
    pictures = {name: plt.imread(name) for name in ("speed_against_error.png", "errors.png")}
    assert sorted(os.listdir(folder)) == sorted(pictures), os.listdir(folder)
    os.chdir("/")

rows = names["rows"]
assert len(rows) == len(names["REPRESENTATIONS"]) * 2
errors = {(row["representation"], row["level"]): row["error"] for row in rows}
assert errors["GRID", 4] < errors["GRID", 3]
assert all(row["coherent"] > 0 and row["incoherent"] > 0 for row in rows)
for name, picture in pictures.items():
    assert picture.std() > 0.05, name  # something is drawn
print("the example runs")
