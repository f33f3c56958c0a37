#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Tests the examples of the codec: encode_grid writes a file; file_to_obj reads it and writes all of its quads.
#
#   examples.sh ENCODE_GRID FILE_TO_OBJ
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() {
  echo "FAILED: $*" >&2
  exit 1
}

"$1" "$folder/grid.cbvh" > "$folder/output" || fail "encode_grid does not run"
cat "$folder/output"
"$2" "$folder/grid.cbvh" > "$folder/grid.obj" || fail "file_to_obj does not run"
[ "$(grep -c '^f ' "$folder/grid.obj")" = 4096 ] || fail "the OBJ has other than 64 x 64 quads"
[ "$(grep -c '^v ' "$folder/grid.obj")" = 4624 ] || fail "the OBJ has other than 16 blocks of 17 x 17 vertices"
# x and y are 0 to 64, as they were encoded
awk '$1 == "v" { if ($2 != int($2) || $3 != int($3) || $2 < 0 || $2 > 64 || $3 < 0 || $3 > 64) exit 1 }' \
  "$folder/grid.obj" || fail "x or y of a vertex is not an integer from 0 to 64"

for arguments in "$folder/none.cbvh" "$folder/output"; do
  ! "$2" "$arguments" > "$folder/out" 2> "$folder/error" || fail "file_to_obj reads $arguments"
  grep -qF "$arguments: " "$folder/error" || fail "file_to_obj does not name $arguments in its message"
done
! "$2" "$folder/grid.cbvh" > /dev/full 2> "$folder/error" || fail "file_to_obj fills the disk"
grep -q "standard output" "$folder/error" || fail "file_to_obj does not report a full disk"
! "$1" "$folder/no/grid.cbvh" 2> "$folder/error" || fail "encode_grid writes into a folder that does not exist"
grep -qF "$folder/no/grid.cbvh" "$folder/error" || fail "encode_grid does not name the file in its message"
