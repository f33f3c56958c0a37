#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Compares the shaders' registers and code on AMD's navi31 with limits, without a GPU: RADV of the Mesa that
# scripts/newer_mesa.sh unpacked compiles them. Skipped without it: other versions of Mesa give other numbers.
#
#   shader_statistics.sh PROGRAM    the program test_shader_statistics
set -eu
cd "$(dirname -- "$0")/../.."
for driver in build/mesa/usr/lib/*/libvulkan_radeon.so; do
  [ -e "$driver" ] || {
    echo "skipped: no RADV in build/mesa, see scripts/newer_mesa.sh"
    exit 77
  }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
printf '{"file_format_version": "1.0.0", "ICD": {"api_version": "1.4.305", "library_path": "%s"}}\n' \
  "$PWD/$driver" > "$folder/radv.json"
VK_DRIVER_FILES="$folder/radv.json" VK_ICD_FILENAMES="$folder/radv.json" RADV_FORCE_FAMILY=navi31 \
  MESA_SHADER_CACHE_DISABLE=true "$1"
