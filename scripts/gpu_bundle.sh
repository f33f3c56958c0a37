#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# gpu_bundle.sh [FOLDER]
#
# Collects into FOLDER (default: build/gpu_bundle) everything that gpu_measure.sh requires to measure on another
# machine: the benchmark without image libraries, and its shared libraries except for libc. The other machine needs
# only a Vulkan driver. Copy the folder there, and run
#
#   FOLDER/gpu_measure.sh RESULTS

arguments=1
. "$(dirname -- "$0")/lib.sh"
folder=${1:-build/gpu_bundle}

[ -e build/release/build.ninja ] || cmake --preset release
cmake --build build/release --target cbvh_bench_bare

program=build/release/tutorials/bench/cbvh_bench_bare
rm -rf "$folder"
mkdir -p "$folder/bin" "$folder/lib" "$folder/loader"
cp "$program" "$folder/bin/"
cp scripts/gpu_measure.sh "$folder/"

# The C library is left out: it belongs to the kernel and the driver of the other machine.
ldd "$program" | awk '$2 == "=>" && $3 ~ "^/" { print $1, $3 }' | while read -r name path; do
  case $name in libc.so.* | libm.so.* | libpthread.so.* | libdl.so.* | librt.so.*) continue ;; esac
  cp -L "$path" "$folder/lib/$name"
done

# for machines without a Vulkan loader
loader=$(ldconfig -p | awk '$1 == "libvulkan.so.1" { print $NF; exit }')
[ -n "$loader" ] && cp -L "$loader" "$folder/loader/libvulkan.so.1"

strip --strip-unneeded "$folder"/bin/* "$folder"/lib/*
du -sh "$folder"
