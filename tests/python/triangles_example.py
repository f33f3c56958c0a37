#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Runs the example of triangles with a smaller scene, and checks that its triangles match the hits.

    triangles_example.py SKIN-TRIANGLES.PY
"""

import sys

import numpy as np
from run_example import run_example

names = run_example(sys.argv[1], {"SCENE": '"cube"', "LEVEL": "4", "SIZE": "(96, 72)"}, ("skin_triangles.png",))
hit = names["hits"].hit
assert hit.sum() > 1000
assert np.nanmax(names["off"]) < 1e-5
weights = names["weights"][hit]
assert np.abs(weights.sum(-1) - 1).max() < 1e-3 and weights.min() > -0.05, weights.min()
assert len(names["mesh"]["quads"]) == 6 * 16 * 16
print("the example runs")
