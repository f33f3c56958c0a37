#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Tests the wheel in output/ on a clean Debian 12, 13 and testing with their own versions of Python, NumPy and Embree:
# wheel.py installs and uses it, the tests of the module pass, and scripts/demo.sh renders with its program. Requires
# root, debootstrap, the machine's package registry and 3 GB. The wheel must be built from the committed state.
#
#   wheel_roots.sh
#   wheel_roots.sh inside    what runs on each of them
set -eu
cd "$(dirname -- "$0")/../.."

if [ "${1:-}" = inside ]; then
  apt-get -qq update
  apt-get -qq -y -o Dpkg::Use-Pty=0 install --no-install-recommends binutils python3-numpy python3-venv \
    '?name(^libembree[34]-[34]$)'
  python3 -c "import sys, numpy; print('Python', sys.version.split()[0], 'with NumPy', numpy.__version__)"
  python3 -B tests/python/wheel.py output "$(sed -n 's/^project(embree-cbvh VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)"
  rm -rf build/wheel-environment
  python3 -m venv --system-site-packages build/wheel-environment
  build/wheel-environment/bin/pip install -q --no-index --no-deps output/embree_cbvh-*.whl
  for test in cages models geometries terrains rasters scenes files errors interrupts; do
    build/wheel-environment/bin/python -B "tests/python/$test.py"
  done
  scripts/prebuilt.sh # the demo would build if the wheel did not fit
  scripts/demo.sh --short
  exit
fi

for system in debian12 debian13 debian14; do
  scripts/roots.sh "$system" -- true
  output=${CBVH_ROOTS:-build/roots}/$system/root/gcc/embree-cbvh/output
  rm -rf "$output"
  mkdir "$output"
  cp output/embree_cbvh-*.whl "$output/"
  scripts/roots.sh "$system" -- tests/python/wheel_roots.sh inside
done
