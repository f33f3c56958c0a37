# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Runs an example from the first cell to the last."""

import os
import re
import tempfile

import matplotlib.pyplot as plt


def run_example(path, smaller, pictures):
    """smaller: settings to override, by name. pictures: all files that it must write. Returns its names."""
    with open(path, encoding="utf-8") as file:
        code = file.read()
    for name, value in smaller.items():
        code, count = re.subn(rf"^{name} = .*$", f"{name} = {value}", code, flags=re.MULTILINE)
        assert count == 1, name
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        names = {"__name__": "__main__"}
        exec(compile(code, path, "exec"), names)  # pylint: disable=exec-used
        drawn = {name: plt.imread(name) for name in pictures}
        assert sorted(os.listdir(folder)) == sorted(drawn), os.listdir(folder)
        os.chdir("/")
    for name, picture in drawn.items():
        assert picture.std() > 0.05, name  # the picture is not empty
    return names
