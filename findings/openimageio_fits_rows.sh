#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# FITS, the format of telescopes and of some elevation models, stores the rows of an image from the bottom up.
#
# Guess: OpenImageIO reads the rows 30, 20, 10 of a file whose data is 10, 20, 30.
#
# Seen (OpenImageIO 2.4.7 of Debian 12): it reads 0, 30, 20, without an error. All rows are one late: the first row is
# read behind the data, and the lowest row of the image is lost.
#
# Our programs reject FITS files for this reason (docs/programs.md).
. "$(dirname -- "$0")/debian_root.sh"
install_pinned bookworm openimageio-tools=2.4.7.1+dfsg-2

{
  for card in "SIMPLE  =                    T" "BITPIX  =                    8" "NAXIS   =                    2" \
    "NAXIS1  =                    1" "NAXIS2  =                    3" END; do
    printf '%-80s' "$card"
  done
  printf '%2400s' '' # header and data are multiples of 2880 bytes
  printf '\012\024\036'
  head -c 2877 /dev/zero
} > "$root/rows.fits"
rows=$(in_root oiiotool --dumpdata "$root/rows.fits" | sed -n 's/.*Pixel.*: \([0-9]*\) .*/\1/p' | tr '\n' ' ')
observe "rows from the top" "0 30 20 " "$rows"
