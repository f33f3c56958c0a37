#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# glsl.sh GLSLC CODEC SHADER...
#
# Compiles as GLSL: each header of the folder CODEC by itself, and the shaders. A new header
# includes language.h, or is named here as one of C++ alone.

set -u
glslc=$1
codec=$2
shift 2

command -v "$glslc" > /dev/null || { echo "skipped: $glslc was there when this was configured, and is not now"; exit 77; }

cpp_only="kinds.h primitive_type.h isa_namespace.h lanes.h"

failed=0
fail() {
  echo "$1" >&2
  failed=1
}

# compile NAME: the shader on the standard input
compile() {
  "$glslc" -fshader-stage=compute -I "$codec" --target-env=vulkan1.2 -Werror -o /dev/null - || fail "$1 does not compile as GLSL"
}

for header in $cpp_only; do
  test -f "$codec/$header" || fail "$header, named here, is not in $codec"
done

count=0
for path in "$codec"/*.h; do
  header=${path##*/}
  case " $cpp_only " in *" $header "*) continue ;; esac
  count=$((count + 1))
  compile "$header" <<END
#version 460
#include "$header"
#include "$header"
#ifndef CBVH_LANGUAGE_H
#error $header includes language.h neither itself nor by others, and glsl.sh does not name it as one of C++ alone
#endif
layout(local_size_x = 1) in;
void main() {}
END
done
test $count -gt 1 || fail "there are no headers in $codec"

for shader in "$@"; do
  if test -f "$shader"; then compile "$shader" < "$shader"; else fail "$shader is not there"; fi
done

test $failed = 0 && echo "compiled as GLSL: $count headers; shaders: $#"
exit $failed
