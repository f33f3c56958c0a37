#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Tests the example displacement_map: pictures of its own heights and of a PGM, with and without comments in the header.
#
#   displacement_map.sh DISPLACEMENT_MAP
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# map NAME HEADER: writes 4 x 4 heights.
map() { printf "$2"'0123456789abcdef' > "$folder/$1.pgm"; }

"$1" "$folder/waves.picture" || fail "displacement_map does not run"
map plain 'P5 4 4 255\n'
map gimp 'P5\n# Created by GIMP\n4 4 # columns, rows\n255\n'
for name in plain gimp; do
  "$1" "$folder/$name.picture" "$folder/$name.pgm" > "$folder/out" || fail "displacement_map does not read $name"
done
cmp "$folder/plain.picture" "$folder/gimp.picture" || fail "a comment changes the picture"
! cmp -s "$folder/plain.picture" "$folder/waves.picture" || fail "the map has no effect"

map text 'P2\n4 4\n255\n'
map wide 'P5\n4 4\n2551\n'
map empty 'P5\n0 4\n255\n'
map short 'P5\n5 4\n255\n'
for name in text wide empty short none; do
  ! "$1" "$folder/picture" "$folder/$name.pgm" 2> "$folder/error" || fail "displacement_map reads $name"
  grep -q "$name.pgm.* \(32768\|20\) " "$folder/error" || fail "the message does not name $name.pgm"
done
! "$1" /dev/full 2> "$folder/error" || fail "displacement_map fills the disk"
grep -q "/dev/full" "$folder/error" || fail "displacement_map does not report a full disk"
