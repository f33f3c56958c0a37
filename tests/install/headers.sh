#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Checks that each of our public headers compiles alone and before all others (cbvh/embree.h after Embree's), in C99 and
# in C++11, without warnings, and does not change Embree's types.
#
#   headers.sh FOLDER-OF-EMBREE3 FOLDER-OF-CBVH [HEADER-TO-SKIP...]
set -eu
embree=$1 cbvh=$2
shift 2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/include"
ln -s "$embree" "$work/include/embree3"
ln -s "$cbvh" "$work/include/cbvh"
failed=0

# check HEADER...: compiles a program that includes them in this order
check() {
  {
    printf '#include <%s>\n' "$@" embree3/rtcore.h
    echo 'int main(void) {'
    echo '  struct RTCRayHit hit;'
    echo '  struct RTCIntersectContext context;'
    echo '  rtcInitIntersectContext(&context);'
    echo '  hit.ray.tfar = 0;'
    echo '  rtcIntersect1(0, &context, &hit);'
    echo '  rtcOccluded1(0, &context, &hit.ray);'
    echo '  return (int)hit.ray.tfar;'
    echo '}'
  } > "$work/first.c"
  for compiler in "cc -x c -std=c99" "c++ -x c++ -std=c++11"; do
    $compiler -Wall -Wextra -pedantic -Werror -I"$work/include" -fsyntax-only "$work/first.c" ||
      {
        echo "FAILED: $* by $compiler" >&2
        failed=1
      }
  done
}

for header in "$embree"/rtcore_compress*.h "$embree"/rtcore_surface.h "$embree"/rtcore_vulkan.h; do
  name=${header##*/}
  case " $* " in *" $name "*) continue ;; esac
  check "embree3/$name"
done
check cbvh/cbvh.h
check embree3/rtcore.h cbvh/embree.h
exit $failed
