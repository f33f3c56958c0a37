#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds what is out of date and runs all tests.
#
#   scripts/test.sh [--all-isas] [CTEST-OPTION...]    for example -R abi, or -L quick
#
# Builds for SSE2 and the best instruction set of this machine, into build/host, and fuzzes for a few seconds. With
# --all-isas, which must come first, builds for every instruction set, into build/release, and fuzzes for longer.
#
# On Debian 12 the Vulkan tests use lavapipe from the backports, which supports ray queries. To use another driver,
# set VK_DRIVER_FILES to its description: scripts/test.sh -L gpu

arguments=any # of ctest
. "$(dirname -- "$0")/lib.sh"
preset=host
if [ "${1:-}" = --all-isas ]; then
  preset=release
  shift
fi

# Runs the tests. Prints the last lines of each failed test at the end, where a reader of a long log looks first.
run_tests() {
  ctest --preset "$preset" -j "$jobs" "$@" && return
  awk -v lines=40 '
    FNR == NR { sub(/^[0-9]*:/, ""); failed[$0]; next }
    /^[0-9]+\/[0-9]+ Testing: / { print_last(); n = 0; name = $0; sub(/^[^:]*: /, "", name); wanted = name in failed }
    wanted { line[n++] = $0 }
    END { print_last() }
    function print_last(  i) {
      if (n) print "== failed: " name
      for (i = n > lines ? n - lines : 0; i < n; i++) print line[i]
    }' "build/$preset/Testing/Temporary/LastTestsFailed.log" "build/$preset/Testing/Temporary/LastTest.log"
  return 1
}

phase "packages" install_packages
phase "configure, get upstream" configure "$preset"
phase "build" build "$preset"
newer=
[ -n "${VK_DRIVER_FILES:-}" ] || ! grep -q '^VERSION_CODENAME=bookworm' /etc/os-release ||
  newer=$(scripts/newer_mesa.sh build/mesa) || newer=
[ -z "$newer" ] || export VK_DRIVER_FILES="$newer"
phase "tests" run_tests "$@"
