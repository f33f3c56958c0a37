#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Embree's own verifier, Debian's build of it, on one instruction set of our library: whatever passes on
# surfaces that are not compressed passes on each kind of compressed ones.
#
#   embree_verify.sh DIRECTORY-OF-OUR-LIBRARY ISA [KIND...]      KIND: grid, voxel, leaf, vert; all unless given
#
# It runs all groups that have subdivision surfaces or grids, for half a minute a kind. Left out are
#   - most scene flags of update, instancing, overlapping_primitives and watertight_subdiv, which run for a minute;
#   - of update, rays in streams and any hits, which intersection_filter has;
#   - ray_masks, which fails without compression as well;
#   - memory_consumption and benchmarks, which measure, and get_bounds, which has grids, whose bounds the lattice moves;
#   - higher intensities: 0.1 is 3 random scenes a regression test, where Embree's default is 30.
set -euf
ours=$1 isa=$2
shift 2
kinds=${*:-grid voxel leaf vert}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset EMBREE_CBVH
cd "$work"

embree_verify --print-tests > tests || true # its exit status says nothing
# Upstream's tests know only the instruction sets that this machine has.
grep -q "^ *$isa\\." tests || { echo "this machine does not run $isa"; exit 77; }

# The verifier's options take no parentheses.
tests="buffer_stride.subdivs empty_geometry build.Static build.Dynamic new_delete_geometry enable_disable_geometry
  disable_detach_geometry overlapping_primitives.StaticFast.MediumQuality
  instancing.instancing.StaticFast.MediumQuality instancing.instancing.DynamicCompactRobust.LowQuality
  interpolate.subdiv intersection_filter.subdiv watertight_subdiv.StaticRobust ray_alignment_test.*.sphere.subdiv
  buffer_stride.grids interpolate.grid watertight_grids.StaticRobust regression_"
for rays in 1 4 8 16; do
  for quality in deformable dynamic; do
    tests="$tests update.$quality.DynamicFast.LowQuality.Intersect$rays update.$quality.DynamicCompactRobust.LowQuality.Intersect$rays"
  done
done
runs=""
for test in $tests; do
  case $test in update.*|*subdivs|*.grids|*.sphere.subdiv) end="" ;; *) end=".*" ;; esac
  runs="$runs --run $isa.$test$end"
done

# verify NAME OPTION...: runs $runs; writes the names of the tests that pass, one a line, to NAME, and of those that do not to
# NAME.lost. Names may come twice.
verify() {
  name=$1
  shift
  status=0
  LD_LIBRARY_PATH=$ours embree_verify --no-colors --flatten --intensity 0.1 "$@" $runs > log 2>&1 || status=$?
  sed -n 's/^ *\([^ ]*\) \.\.\..* \[PASSED\].*/\1/p' log | sort > "$name"
  sed -n '/\[PASSED\]/!s/^ *\([^ ]*\) \.\.\..*/\1/p' log | sort > "$name.lost"
  echo "$isa, $name: $(wc -l < "$name") tests pass, $(wc -l < "$name.lost") do not, status $status"
}

# What does not pass is run once more without compression; all is, where the verifier did not come to its end.
all=$runs
failed=0
for kind in $kinds; do
  runs=$all
  verify "cbvh.$kind" --rtcore "subdiv_accel=cbvh.$kind"
  mv log log.kind
  if [ "$status" != 0 ] || [ "$(wc -l < "cbvh.$kind")" -le 700 ]; then
    verify uncompressed
    [ "$(wc -l < uncompressed)" -gt 700 ] || { tail -n 20 log; echo "few tests pass without compression, status $status" >&2; exit 1; }
  elif [ -s "cbvh.$kind.lost" ]; then
    runs=$(sed 's/^/--run /' "cbvh.$kind.lost" | sort -u | tr '\n' ' ')
    verify uncompressed
  else
    continue
  fi
  comm -23 uncompressed "cbvh.$kind" > lost
  [ -s lost ] || continue
  failed=1
  echo "pass only without compression, $(wc -l < lost) tests:"
  head -n 20 lost
  grep -v PASSED log.kind | tail -n 20
done
exit $failed
