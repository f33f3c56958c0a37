#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# A PGM file names the value of white. It may be any number up to 65535, for example 40000 for heights in decimeters.
#
# Guess: OpenImageIO divides samples by this number, so that a sample of 40000 is read as 1, and 20000 as 0.5.
#
# Seen (OpenImageIO 2.4.7 of Debian 12): 20000 is read as 32767/65535, one step below 0.5, and 40000 as 23697/65535 or
# 0.36, without an error: 40000 * 65535 exceeds an integer of 32 bits.
#
# In height maps, mountains become craters. Our programs read PGM, PPM and PFM without OpenImageIO (docs/programs.md).
. "$(dirname -- "$0")/debian_root.sh"
install_pinned bookworm openimageio-tools=2.4.7.1+dfsg-2

printf 'P5\n2 1\n40000\n\116\040\234\100' > "$root/heights.pgm" # 20000 and 40000
values=$(in_root oiiotool --dumpdata "$root/heights.pgm" | sed -n 's/.*Pixel.*: *//p' | tr '\n' ' ')
observe "20000 and 40000 of 40000 are read as" "32767 (0.49999237) 23697 (0.36159304) " "$values"
