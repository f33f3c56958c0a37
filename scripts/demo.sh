#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds the renderer on a fresh Debian 12 or 13. Renders trex, then compares frog and cube in every representation: the
# rows of README.md for this machine.
#
#   scripts/demo.sh [--build] [--short] [DIRECTORY]    writes the pictures to DIRECTORY (default: output/demo)
#
#   --build    builds even if output/ has a wheel or Debian packages that fit, see scripts/prebuilt.sh
#   --short    renders only the first picture
#
# The library in build/demo supports only this machine's instruction set, subdivision surfaces, triangles and single
# rays. scripts/test.sh builds the complete library in build/host and tests it.

build=no short=no
while :; do
  case ${1:-} in
    --build) build=yes ;;
    --short) short=yes ;;
    *) break ;;
  esac
  shift
done
arguments=1
. "$(dirname -- "$0")/lib.sh"
output=${1:-output/demo}

# render DIRECTORY SCENE OPTION...
render() {
  directory=$1 scene=$2
  shift 2
  "$program" --scene "$scene" --output "$output/$directory" "$@"
}

if [ $build = no ] && scripts/prebuilt.sh; then
  program=build/prebuilt/cbvh_render
else
  program=build/demo/tutorials/render/cbvh_render
  phase "packages" install_packages "the demo does not require"
  phase "configure, get upstream" configure demo
  phase "build for this machine alone" build demo embree cbvh_render
fi
phase "render trex" render . trex --level 6
if [ $short = no ]; then
  phase "compare frog" render frog frog --level 6 --compare --speed --exr
  phase "compare cube" render cube cube --compare --speed --exr
fi

echo "== program"
echo "$program"
echo "== pictures"
find "$output" -type f \( -name '*.png' -o -name '*.exr' \) | sort
