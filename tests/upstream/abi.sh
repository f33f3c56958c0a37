#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Checks that our library and headers are a superset of Debian's: no function was removed or changed, and the
# additions are those of our API.
#
#   abi.sh ABIDIFF STOCK-LIBRARY OUR-LIBRARY OUR-HEADERS
set -eu
abidiff=$1 stock=$2 ours=$3 headers=$4
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export LC_ALL=C

"$abidiff" --no-added-syms "$stock" "$ours" || {
  echo "abidiff: removed or changed symbols" >&2
  exit 1
}

symbols() { nm --dynamic --defined-only "$1" | awk '$2 != "A" { print $2, $3 }' | sort; } # A: names of versions
symbols "$stock" > "$work/stock"
symbols "$ours" > "$work/ours"
[ "$(wc -l < "$work/stock")" -gt 100 ]
comm -23 "$work/stock" "$work/ours" > "$work/removed"
comm -13 "$work/stock" "$work/ours" | cut -d ' ' -f 2 | sort > "$work/added"
[ ! -s "$work/removed" ] || {
  echo "removed:"
  cat "$work/removed"
  exit 1
}
# functions of rtcore_*.h and cbvh.h, and of kernels/cbvh/backend/flat_scene.h for libembree3_vulkan. Those of cbvh.h
# have a version.
{
  printf '%s\n' rtcFindClosestPoint rtcFlattenScene rtcGetDeviceCompressionProperty \
    rtcGetSceneCompressionStatistics rtcNewContextFromDevice rtcNewGeometryFromSurface rtcNewSurfaceFromGeometry \
    rtcRaiseDeviceError rtcReleaseFlatScene rtcSetGeometryCompression
  grep -o '^CBVH_API .*' "$headers/cbvh.h" | grep -o 'cbvh[A-Za-z0-9]*(' | sed 's/($/@@EMBREE_CBVH_1/'
} | sort > "$work/api"
diff "$work/api" "$work/added" || {
  echo "added symbols are not those of our headers" >&2
  exit 1
}

soname() { readelf -d "$1" | sed -n 's/.*soname: //p'; }
[ "$(soname "$stock")" = "$(soname "$ours")" ]

# Debian's library has no debug information, so abidiff does not see types: the headers must be identical.
for header in /usr/include/embree3/*; do
  cmp "$header" "$headers/${header##*/}"
done
# Our headers support C and C++.
for language in c c++; do
  printf '#include <embree3/%s.h>\n' rtcore rtcore_compression rtcore_surface |
    cc -x "$language" -Wall -Werror -fsyntax-only -I "${headers%/*}" -
done
