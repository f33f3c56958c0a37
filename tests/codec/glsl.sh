#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# glsl.sh GLSLC KERNELS SHADER...
#
# Compiles as GLSL: each header below the folder KERNELS that uses the language of cvert/portable/language.h (it
# contains CVERT_BEGIN or CBVH_BEGIN), by itself, and the shaders.

set -u
glslc=$1
kernels=$2
shift 2

command -v "$glslc" > /dev/null || {
  echo "skipped: $glslc has been removed since the build was configured"
  exit 77
}

failed=0
fail() {
  echo "$1" >&2
  failed=1
}

# compile NAME: compiles the shader on standard input
compile() {
  "$glslc" -fshader-stage=compute -I "$kernels" --target-env=vulkan1.2 -Werror -o /dev/null - ||
    fail "$1 does not compile as GLSL"
}

count=0
for header in $(cd "$kernels" && grep -rlE '^C(VERT|BVH)_BEGIN' cvert cbvh | sort); do
  count=$((count + 1))
  compile "$header" << END
#version 460
#include "$header"
#include "$header"
#ifndef CVERT_PORTABLE_LANGUAGE_H
#error $header has CVERT_BEGIN or CBVH_BEGIN but does not include language.h, neither directly nor indirectly
#endif
layout(local_size_x = 1) in;
void main() {}
END
done
test $count -gt 1 || fail "no headers in $kernels"

for shader in "$@"; do
  if test -f "$shader"; then compile "$shader" < "$shader"; else fail "$shader does not exist"; fi
done

test $failed = 0 && echo "compiled as GLSL: $count headers; shaders: $#"
exit $failed
