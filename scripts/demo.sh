#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds everything on a fresh Debian 12 and renders the two generated scenes in
# every representation, trex also from near.
#
#   scripts/demo.sh [DIRECTORY]    pictures go to DIRECTORY, output/demo by default

. "$(dirname -- "$0")/lib.sh"
output=${1:-output/demo}

# render DIRECTORY SCENE OPTION...
render() {
  directory=$1 scene=$2; shift 2
  build/release/tutorials/render/cbvh_render --scene "$scene" --level 6 --frame-level 2 --output "$output/$directory" "$@"
}
all=naive,grid,cgrid,cvoxel,cvoxel^3,cleaf,cvert

phase "packages" install_packages
phase "configure, get upstream" configure
phase "build" build embree cbvh_render
phase "render trex" render trex trex --representation "$all"
phase "render trex, near" render trex_close trex --view close --representation grid,cvoxel^3,cleaf,cvert --no-speed
phase "render cube" render cube cube --representation "$all"

echo "== pictures"
find "$output" -type f \( -name '*.png' -o -name '*.exr' \) | sort
