#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds what a picture needs on a fresh Debian 12 or 13, renders trex in cVERT, and then trex and cube in every
# representation, with their speeds and errors.
#
#   scripts/demo.sh [DIRECTORY]    pictures go to DIRECTORY, output/demo by default
#
# The library that it builds, in build/demo, has this machine's instruction set alone, subdivision surfaces and
# triangles, and single rays: scripts/test.sh builds and tests the whole one, in build/release.

arguments=1
. "$(dirname -- "$0")/lib.sh"
output=${1:-output/demo}

# render DIRECTORY SCENE OPTION...
render() {
  directory=$1 scene=$2; shift 2
  build/demo/tutorials/render/cbvh_render --scene "$scene" --output "$output/$directory" "$@"
}

phase "packages" install_packages "what follows the demo"
phase "configure, get upstream" configure demo
phase "build for this machine alone" build demo embree cbvh_render
phase "render trex" render . trex --level 6
phase "compare trex" render trex trex --compare --speed --exr
phase "compare trex from near" render trex_close trex --view close --compare --exr
phase "compare cube" render cube cube --compare --speed --exr

echo "== pictures"
find "$output" -type f \( -name '*.png' -o -name '*.exr' \) | sort
