#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# What `cmake --install` lays down serves a program that says find_package(embree 3).
#
#   test.sh CMAKE BUILD-DIRECTORY
set -eu
cmake=$1 build=$2
here=$(cd -- "$(dirname -- "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$cmake" --install "$build" --prefix "$work/prefix" > "$work/log" || { cat "$work/log"; exit 1; }
[ -e "$work"/prefix/lib/libembree3.so.3 ]
for header in rtcore.h rtcore_compression.h; do
  [ -f "$work/prefix/include/embree3/$header" ]
done
if [ -e "$build/kernels/vulkan/libembree3_vulkan.so.3" ]; then
  [ -e "$work"/prefix/lib/libembree3_vulkan.so.3 ]
  [ -f "$work/prefix/include/embree3/rtcore_vulkan.h" ]
  [ -f "$work/prefix/include/embree3/cbvh.glsl" ]
  # it finds the library beside it
  ldd "$work/prefix/lib/libembree3_vulkan.so.3" | grep -q "libembree3.so.3 => $work/prefix/lib/"
fi
# A link back into the source tree would break elsewhere.
for link in $(find "$work/prefix" -type l); do
  case $(readlink "$link") in
    */*) echo "$link leads out of the installation" >&2; exit 1 ;;
  esac
done

cp "$here/CMakeLists.txt" "$here/renderer.cpp" "$work/"
"$cmake" -S "$work" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/prefix" > "$work/log" || { cat "$work/log"; exit 1; }
"$cmake" --build "$work/build" > "$work/log" || { cat "$work/log"; exit 1; }
library=$(env -u LD_LIBRARY_PATH "$work/build/renderer")
case $library in
  "$work"/prefix/*) echo "runs on the installed library" ;;
  *) echo "runs on $library" >&2; exit 1 ;;
esac
