#!/usr/bin/python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Writes an elevation raster from the sample data of Matplotlib (Jacksboro fault, Tennessee; 403 x 344 samples of 3 arc
seconds, in meters) as a TIFF of floats.

    jacksboro.py jacksboro.tif

Debian's package python3-matplotlib contains the raster and depends on NumPy and Pillow.
"""

import sys

from matplotlib import cbook
import numpy
from PIL import Image


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with numpy.load(cbook.get_sample_data("jacksboro_fault_dem.npz", asfileobj=False)) as raster:
        elevation = raster["elevation"]
    Image.fromarray(elevation.astype(numpy.float32)).save(sys.argv[1])


if __name__ == "__main__":
    main()
