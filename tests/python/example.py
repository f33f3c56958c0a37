#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Runs the example from the first cell to the last with a smaller scene, and checks that it writes its pictures.

    example.py COMPARE-REPRESENTATIONS.PY
"""

import sys

from run_example import run_example

SMALLER = {"SCENE": '"cube"', "LEVELS": "(3, 4)", "SIZE": "(96, 72)", "ROUNDS": "1"}
names = run_example(sys.argv[1], SMALLER, ("speed_against_error.png", "errors.png"))

rows = names["rows"]
assert len(rows) == len(names["REPRESENTATIONS"]) * 2
errors = {(row["representation"], row["level"]): row["error"] for row in rows}
assert errors["GRID", 4] < errors["GRID", 3]
assert all(row["coherent"] > 0 and row["incoherent"] > 0 for row in rows)
print("the example runs")
