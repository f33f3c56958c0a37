#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Runs Debian's build of Embree's verifier with our library on one instruction set: tests that pass without
# compression must pass with each kind of compression.
#
#   embree_verify.sh DIRECTORY-OF-OUR-LIBRARY ISA [KIND...]      KIND: grid, voxel, leaf, vert (default: all)
#
# Runs all groups that have subdivision surfaces or grids, for half a minute per kind. Excluded are
#   - most scene flags of update, instancing, overlapping_primitives and watertight_subdiv, which run for a minute;
#   - rays in streams and any hits in update; intersection_filter covers them;
#   - ray_masks, which also fails without compression;
#   - watertight_subdiv on the sphere, whose rays start in a cube with corners outside of the smooth surface: correct
#     rays miss it (precision_leaks and bench_cli count rays that leak);
#   - memory_consumption and benchmarks, which measure, and get_bounds, because the lattice moves bounds of grids;
#   - higher intensities: 0.1 gives 3 random scenes per regression test; Embree's default gives 30.
set -euf
ours=$1 isa=$2
shift 2
kinds=${*:-grid voxel leaf vert}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset EMBREE_CBVH
cd "$work"

embree_verify --print-tests > tests || true # ignores the exit status, which is not meaningful
# Upstream's tests include only the instruction sets of this machine.
grep -q "^ *$isa\\." tests || {
  echo "this machine does not support $isa"
  exit 77
}

# The verifier's options do not support parentheses.
tests="buffer_stride.subdivs empty_geometry build.Static build.Dynamic new_delete_geometry enable_disable_geometry
  disable_detach_geometry overlapping_primitives.StaticFast.MediumQuality
  instancing.instancing.StaticFast.MediumQuality instancing.instancing.DynamicCompactRobust.LowQuality
  interpolate.subdiv intersection_filter.subdiv
  watertight_subdiv.StaticRobust.*.plane.subdiv ray_alignment_test.*.sphere.subdiv
  buffer_stride.grids interpolate.grid watertight_grids.StaticRobust regression_"
for rays in 1 4 8 16; do
  for quality in deformable dynamic; do
    for flags in DynamicFast DynamicCompactRobust; do
      tests="$tests update.$quality.$flags.LowQuality.Intersect$rays"
    done
  done
done
runs=""
for test in $tests; do
  case $test in update.* | *subdivs | *.grids | *.sphere.subdiv | *.plane.subdiv) end="" ;; *) end=".*" ;; esac
  runs="$runs --run $isa.$test$end"
done

# verify NAME OPTION...: runs $runs. Writes the names of passing tests, one per line, to NAME, and of failing tests to
# NAME.lost. Names may occur twice.
verify() {
  name=$1
  shift
  status=0
  LD_LIBRARY_PATH=$ours embree_verify --no-colors --flatten --intensity 0.1 "$@" $runs > log 2> messages || status=$?
  sed -n 's/^ *\([^ ]*\) \.\.\..* \[PASSED\].*/\1/p' log | sort > "$name"
  sed -n '/\[PASSED\]/!s/^ *\([^ ]*\) \.\.\..*/\1/p' log | sort > "$name.lost"
  echo "$isa, $name: $(wc -l < "$name") tests pass, $(wc -l < "$name.lost") do not, status $status"
}

# Runs failing tests once more without compression; runs all tests if the verifier did not finish.
all=$runs
failed=0
for kind in $kinds; do
  runs=$all
  verify "cbvh.$kind" --rtcore "subdiv_accel=cbvh.$kind"
  mv log log.kind
  if [ "$status" != 0 ] || [ "$(wc -l < "cbvh.$kind")" -le 700 ]; then
    verify uncompressed
    [ "$(wc -l < uncompressed)" -gt 700 ] ||
      {
        tail -n 20 log
        echo "too few tests pass without compression, status $status" >&2
        exit 1
      }
  elif [ -s "cbvh.$kind.lost" ]; then
    runs=$(sed 's/^/--run /' "cbvh.$kind.lost" | sort -u | tr '\n' ' ')
    verify uncompressed
  else
    continue
  fi
  comm -23 uncompressed "cbvh.$kind" > lost
  [ -s lost ] || continue
  failed=1
  echo "$(wc -l < lost) tests pass only without compression:"
  head -n 20 lost
  grep -v PASSED log.kind | tail -n 20
done
exit $failed
