#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""The example of triangles runs, on a smaller scene, and its triangles are where the hits are.

usage: triangles_example.py SKIN-TRIANGLES.PY"""

import os
import re
import sys
import tempfile

import matplotlib.pyplot as plt
import numpy as np

EXAMPLE = sys.argv[1]
SMALLER = {"SCENE": '"cube"', "LEVEL": "4", "SIZE": "(96, 72)"}

with open(EXAMPLE, encoding="utf-8") as file:
    code = file.read()
for name, value in SMALLER.items():
    code, count = re.subn(rf"^{name} = .*$", f"{name} = {value}", code, flags=re.MULTILINE)
    assert count == 1, name

with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    names = {"__name__": "__main__"}
    exec(compile(code, EXAMPLE, "exec"), names)  # pylint: disable=exec-used
    picture = plt.imread("skin_triangles.png")
    os.chdir("/")

assert picture.std() > 0.05  # something is drawn
hit = names["hits"].hit
assert hit.sum() > 1000
assert np.nanmax(names["off"]) < 1e-5
weights = names["weights"][hit]
assert np.abs(weights.sum(-1) - 1).max() < 1e-3 and weights.min() > -0.05, weights.min()
assert len(names["mesh"]["quads"]) == 6 * 16 * 16
print("the example runs")
