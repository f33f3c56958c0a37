#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# GDAL stores rasters of integers with as few bits as they need, for example with -co NBITS=12 for heights up to 4095.
#
# Guess: OpenImageIO reads such a height as the same integer of 16 bits.
#
# Seen (OpenImageIO 2.4.7 of Debian 12, GDAL 3.6.2): 1000 is read as 16003, because integers are stretched so that 4095
# becomes 65535. That suits colors. The attribute oiio:BitsPerSample, 12, allows to compute the height again.
#
# Heights of cbvh_terrain were 16 times too large; it now uses the attribute.
. "$(dirname -- "$0")/debian_root.sh"
install_pinned bookworm openimageio-tools=2.4.7.1+dfsg-2 gdal-bin=3.6.2+dfsg-1+b2

export PROJ_LIB="$root/system/usr/share/proj" GDAL_DATA="$root/system/usr/share/gdal"
printf 'ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 10\n1000 4095\n' > "$root/heights.asc"
values() { in_root oiiotool --dumpdata "$1" | sed -n 's/.*Pixel.*: *\([0-9]*\) .*/\1/p' | tr '\n' ' '; }
in_root gdal_translate -q -ot UInt16 "$root/heights.asc" "$root/16.tif"
in_root gdal_translate -q -ot UInt16 -co NBITS=12 "$root/heights.asc" "$root/12.tif"
observe "1000 and 4095 of 16 bits are read as" "1000 4095 " "$(values "$root/16.tif")"
observe "1000 and 4095 of 12 bits are read as" "16003 65535 " "$(values "$root/12.tif")"
