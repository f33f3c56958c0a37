# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Types of arguments that scripts share."""

import argparse
import os
from pathlib import Path


def existing_program(path):
    """Returns the path of a program that can be started. For `type` of add_argument."""
    if not (os.path.isfile(path) and os.access(path, os.X_OK)):
        raise argparse.ArgumentTypeError(f"{path}: no such program: expected one of a finished build")
    return Path(path)
