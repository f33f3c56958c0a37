#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# GDAL halves the size of elevation rasters with -co NBITS=16, which stores floats of 16 bits. Missing samples usually
# have the value -9999, which such a float cannot represent. A tag of the file names the value.
#
# Guess: GDAL rounds the value in the tag as it rounds the samples, so that they remain missing.
#
# Seen (GDAL 3.6.2 of Debian 12): missing samples are -9992, and the tag still says -9999. GDAL itself then counts them
# as heights: the smallest height of the raster is -9992.
#
# cbvh_terrain rounds the value of the tag to the type of the samples before it compares them (map_image.cpp).
. "$(dirname -- "$0")/debian_root.sh"
install_pinned bookworm gdal-bin=3.6.2+dfsg-1+b2

export PROJ_LIB="$root/system/usr/share/proj" GDAL_DATA="$root/system/usr/share/gdal"
printf 'ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\nnodata_value -9999\n100 -9999\n200 300\n' \
  > "$root/heights.asc"
smallest() { in_root gdalinfo -stats "$1" | sed -n 's/ *Minimum=\([^,]*\),.*/\1/p'; }
observe "the smallest height is" "100.000" "$(smallest "$root/heights.asc")"
in_root gdal_translate -q -ot Float32 -co NBITS=16 "$root/heights.asc" "$root/heights.tif"
observe "with 16 bits it is" "-9992.000" "$(smallest "$root/heights.tif")"
observe "and missing samples are" "-9999" "$(in_root gdalinfo "$root/heights.tif" | sed -n 's/ *NoData Value=//p')"
