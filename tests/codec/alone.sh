#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Checks that the codec does not depend on Embree, TBB or the kernels: each header and source compiles by itself as
# C++14, and includes only files of the codec and of the system.
#
#   alone.sh COMPILER KERNELS
set -eu
compiler=$1
cd "$2"
failed=0

# check FILE FLAG...
check() {
  file=$1
  shift
  if ! included=$("$compiler" -std=c++14 -x c++ -include "$file" "$@" -fsyntax-only -Wall -Wextra -H /dev/null \
    2>&1); then
    echo "$included" | grep -v '^[.!]' | head -n 20
    echo "$file does not compile by itself ($*)"
    failed=1
  fi
  others=$(echo "$included" | sed -n 's/^\.* //p' | grep -iE '(^|/)(embree|cbvh|tbb|oneapi)' || true)
  [ -z "$others" ] || {
    echo "$file includes $others"
    failed=1
  }
}

# the ISAs of other processors
case $("$compiler" -dumpmachine) in aarch64*) foreign="sse avx" ;; *) foreign=neon ;; esac

count=0
for file in cvert/*/*.h cvert/*/*.cpp; do
  for isa in $foreign; do case $file in *_$isa.h) continue 2 ;; esac done
  count=$((count + 1))
  check "$file"
  case $file in
    cvert/encoder/* | */lanes.h | */vertices4.h) check "$file" -DCVERT_PORTABLE ;;
  esac
done
[ "$count" -gt 20 ] || {
  echo "no files of the codec in $2"
  failed=1
}
[ "$failed" != 0 ] || echo "$count files compile by themselves"
exit "$failed"
