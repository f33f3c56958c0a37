#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# The installed module finds the library that is installed with it, also after both were moved.
#
#   install.sh CMAKE BUILD-DIRECTORY PYTHON...    PYTHON: the command of the interpreter, with its arguments
set -eu
cmake=$1 build=$2
shift 2
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:[^=]*=//p' "$build/CMakeCache.txt")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset LD_LIBRARY_PATH EMBREE_CBVH

"$cmake" --install "$build" --prefix "$work/first" > "$work/log" || {
  cat "$work/log"
  exit 1
}
mv "$work/first" "$work/prefix"
[ -f "$work/prefix/share/doc/embree-cbvh/examples/compare_representations.py" ]
[ -f "$work/prefix/share/doc/embree-cbvh/examples/skin_triangles.py" ]
module=$(find "$work/prefix" -name 'embree_cbvh*.so')
[ -f "$(dirname "$module")/embree_cbvh.pyi" ]
PYTHONPATH=$(dirname "$module") "$@" -B - "$work/prefix" "$version" << 'CODE'
import sys
import embree_cbvh

prefix, version = sys.argv[1:]
with open("/proc/self/maps", encoding="utf-8") as maps:
    libraries = {line.split()[-1] for line in maps if "libembree3.so" in line}
assert embree_cbvh.__file__.startswith(prefix + "/lib/python3"), embree_cbvh.__file__
assert embree_cbvh.__version__ == version, embree_cbvh.__version__
assert len(libraries) == 1 and min(libraries).startswith(prefix + "/"), libraries
assert embree_cbvh.build(embree_cbvh.Model.generate("cube"), "cvert", 3).statistics()["compression"]["quads"] == 6 * 64
print("runs on", *libraries)
CODE
