#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# The check of sources, kernels/cbvh/surface/source.h, must name the member that a source lacks: one message for each
# class of source_errors.cpp, in their order, and no other error.
#
#   source_errors.sh SOURCE_ERRORS.CPP COMPILER FLAGS...

set -eu
file=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if LC_ALL=C "$@" -fsyntax-only "$file" > "$work/log" 2>&1; then
  echo "the compiler accepts $file"
  exit 1
fi
sed -n 's|^ *// expected: ||p' "$file" > "$work/expected"
sed -n 's|.*error: static.*a source needs \([^"]*\)"*$|\1|p' "$work/log" > "$work/found"
diff "$work/expected" "$work/found" || {
  cat "$work/log"
  exit 1
}
# In some compilers the caller's assertion also fails.
others=$(grep 'error:' "$work/log" | grep -v 'a source needs' | grep -v 'non-constant condition' || true)
[ -z "$others" ] || {
  echo "$others"
  exit 1
}
