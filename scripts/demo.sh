#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds everything on a fresh Debian 12 and renders the two generated scenes in
# every representation.
#
#   scripts/demo.sh [DIRECTORY]    pictures go to DIRECTORY, output/demo by default

. "$(dirname -- "$0")/lib.sh"
output=${1:-output/demo}

render() {
  build/release/tutorials/render/cbvh_render --scene "$1" --level 6 --frame-level 2 \
    --representation naive,grid,cgrid,cvoxel,cleaf --output "$output/$1"
}

phase "packages" install_packages
phase "configure, get upstream" configure
phase "build" build embree cbvh_render
phase "render trex" render trex
phase "render cube" render cube

echo "== pictures"
find "$output" -type f \( -name '*.png' -o -name '*.exr' \) | sort
