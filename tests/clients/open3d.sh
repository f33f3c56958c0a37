#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Rays of Open3D return the same bytes with our library as with the system's, whether they miss or hit, and find almost
# the same hits in compressed triangles. So do closest points if both libraries build their trees for the same
# instruction set: many points are equally far from several triangles.
#
#   open3d.sh PYTHON DIRECTORY-OF-OUR-LIBRARY SAME-LOWEST-ISA COMPILER [OPTION...]     SAME-LOWEST-ISA: 1 or 0
set -eu
python=$1 ours=$2 same_isa=$3
shift 3
clients=$(cd -- "$(dirname -- "$0")/../install/clients" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset EMBREE_CBVH
fail() {
  echo "FAILED: $*" >&2
  exit 1
}

"$@" -shared -fPIC "$clients/open3d_masks.c" -ldl -o "$work/masks.so"

# queries NAME [VARIABLE=VALUE...]
queries() {
  name=$1
  shift
  env "$@" "$python" -B "$clients/open3d_queries.py" "$work/$name" > "$work/$name.hits" 2> "$work/$name.err" ||
    {
      cat "$work/$name.err"
      fail "Open3D does not run its queries: $name"
    }
}
own="LD_LIBRARY_PATH=$ours${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
queries stock
queries ours "$own"
queries stock_masks LD_PRELOAD="$work/masks.so"
queries ours_masks LD_PRELOAD="$work/masks.so" "$own"
queries compressed LD_PRELOAD="$work/masks.so" "$own" EMBREE_CBVH=1,verbose
for of in "" _masks; do
  cmp "$work/stock$of.rays" "$work/ours$of.rays" || fail "rays$of: results differ"
  [ "$same_isa" = 0 ] || cmp "$work/stock$of.points" "$work/ours$of.points" || fail "closest points$of differ"
done

# of 76,800 rays; each ray that hits the torus hits at least two triangles
read -r hits occluded counts < "$work/ours_masks.hits"
if [ "$hits" -lt 25000 ] || [ "$hits" -gt 35000 ] || [ "$occluded" != "$hits" ] || [ "$counts" -lt $((2 * hits)) ]; then
  fail "with masks, $hits hits, $occluded occluded rays, $counts triangles"
fi
grep -q "compression: .*triangle mesh as" "$work/compressed.err" ||
  {
    cat "$work/compressed.err"
    fail "the torus is not compressed"
  }
read -r found _ _ < "$work/compressed.hits"
if [ "$found" -lt $((hits - hits / 1000)) ] || [ "$found" -gt $((hits + hits / 1000)) ]; then
  fail "$found hits of the compressed torus, expected about $hits"
fi
echo "without masks $(cat "$work/stock.hits"); with masks $(cat "$work/ours_masks.hits"); compressed $found hits"
