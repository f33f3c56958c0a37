#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# With -co SPARSE_OK=TRUE, GDAL stores no tile of a GeoTIFF whose samples are all missing: rasters of islands in an
# ocean become much smaller. Offset and size of such a tile are 0.
#
# Guess: OpenImageIO reads the samples of these tiles as 0.
#
# Seen (OpenImageIO 2.4.7 of Debian 12, GDAL 3.6.2): it refuses the whole raster when it reads such a tile.
#
# cbvh_terrain therefore refuses these rasters, with OpenImageIO's message. gdal_translate without the option writes all
# tiles.
. "$(dirname -- "$0")/debian_root.sh"
install_pinned bookworm openimageio-tools=2.4.7.1+dfsg-2 gdal-bin=3.6.2+dfsg-1+b2

export PROJ_LIB="$root/system/usr/share/proj" GDAL_DATA="$root/system/usr/share/gdal"
printf 'ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 10\n0 0\n' > "$root/sea.asc"
in_root gdal_translate -q -ot Float32 -outsize 512 512 -co TILED=YES -co SPARSE_OK=TRUE "$root/sea.asc" "$root/sea.tif"
observe "GDAL reads the first sample as" "0" \
  "$(in_root gdallocationinfo -valonly "$root/sea.tif" 0 0)"
observe "OpenImageIO says" "Invalid tile byte count, tile 0" \
  "$(in_root oiiotool --stats "$root/sea.tif" 2>&1 | sed -n 's/.*ERROR.*: //p')"
