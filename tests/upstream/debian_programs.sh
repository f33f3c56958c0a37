#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Runs programs of Debian's embree-tools, compiled for Debian's library, with our library: they must render the same
# pictures, and upstream's own tests must pass.
#
#   debian_programs.sh DIRECTORY-OF-OUR-LIBRARY ISA...
set -eu
ours=$1
shift
isas=$*
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset EMBREE_CBVH
cd "$work"

on_ours() { LD_LIBRARY_PATH=$ours "$@"; }
on_ours ldd "$(command -v embree_verify)" | grep -q "libembree3.so.3 => $ours/" ||
  {
    echo "LD_LIBRARY_PATH does not lead to our library" >&2
    exit 1
  }

for program in triangle_geometry subdivision_geometry displacement_geometry instanced_geometry \
  curve_geometry grid_geometry point_geometry interpolation user_geometry intersection_filter; do
  "$program" --size 128 128 -o stock.ppm > stock.log 2>&1 ||
    {
      cat stock.log
      echo "$program fails on Debian's library" >&2
      exit 1
    }
  on_ours "$program" --size 128 128 -o ours.ppm > ours.log 2>&1 || {
    cat ours.log
    echo "$program fails" >&2
    exit 1
  }
  [ "$(wc -c < ours.ppm)" = "$(wc -c < stock.ppm)" ] || {
    echo "$program renders another size" >&2
    exit 1
  }
  # The last bits of a color may differ because of different rounding in another compilation.
  cmp -l stock.ppm ours.ppm | awk -v name="$program" '
    function digit(octal, i) { return length(octal) > i ? substr(octal, length(octal)-i, 1) : 0 }
    function value(octal) { return digit(octal, 2)*64 + digit(octal, 1)*8 + digit(octal, 0) }
    { d = value($2) - value($3); if (d > 2 || d < -2) bad++ }
    END { print name ": " NR " bytes differ, " bad+0 " by more than 2"; exit bad > 128*128*3/1000 }' ||
    {
      echo "$program renders a different picture" >&2
      exit 1
    }
done

embree_verify --print-tests > tests || true # ignores the exit status, which is not meaningful
tested=
for isa in $isas; do
  # Upstream's tests include only the instruction sets of this machine.
  grep -q "^ *$isa\\." tests || continue
  for test in types_test get_bounds get_linear_bounds interpolate new_delete_geometry intersection_filter.subdiv; do
    on_ours embree_verify --no-colors --intensity 0.1 --run "$isa.$test.*" > log 2>&1 ||
      {
        cat log
        echo "embree_verify --run $isa.$test.* fails" >&2
        exit 1
      }
  done
  echo "embree_verify passes for $isa"
  tested=yes
done
[ "$tested" ] || {
  echo "embree_verify lists no tests of $isas" >&2
  exit 1
}
