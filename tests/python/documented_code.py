# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Runs Python code of the documentation."""

import os
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]


def documented_code(page, index):
    """Returns block `index` of Python code on a page."""
    return re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL)[index]


def run_in(folder, code):
    """Runs code in a folder and returns its names."""
    before, names = os.getcwd(), {}
    os.chdir(folder)
    try:
        exec(code, names)  # pylint: disable=exec-used
    finally:
        os.chdir(before)
    return names
