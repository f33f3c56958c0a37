#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Checks the binary interface of libembree_cbvh: types and functions of its header must match libembree_cbvh.abi, or
# extend it. Compares empty functions generated from the header, so that types are known without debug information in
# the library. A change that requires programs to be compiled again is an error. If it is intended, record it with
# --write and raise the version.
#
#   abi.sh HEADER VERSION-SCRIPT [--write]
set -eu
header=$1 versions=$2 here=$(cd -- "$(dirname -- "$0")" && pwd)
command -v abidiff > /dev/null || {
  echo "abidiff is not installed (Debian: abigail-tools)"
  exit 77
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
{
  echo '#include "cbvh/cbvh.h"'
  # A declaration may take several lines.
  awk '/^CBVH_API / { sub(/^CBVH_API /, ""); open = 1 }
       open { text = text " " $0 }
       open && /;$/ { sub(/;$/, " { __builtin_trap(); }", text); print text; text = ""; open = 0 }' "$header"
} > "$work/stubs.c"
cc -g -O0 -w -fPIC -shared -I "$(dirname -- "$header")/.." -Wl,-soname,libembree_cbvh.so.1 \
  -Wl,--version-script="$versions" "$work/stubs.c" -o "$work/libembree_cbvh.so.1"
abidw --no-corpus-path --no-comp-dir-path --no-show-locs --out-file "$work/now.abi" "$work/libembree_cbvh.so.1"
[ "${3:-}" != --write ] || {
  sed "s|path='[^']*/|path='|" "$work/now.abi" > "$here/libembree_cbvh.abi"
  exit 0
}
functions=$(grep -c '<function-decl' "$here/libembree_cbvh.abi")
status=0
abidiff "$here/libembree_cbvh.abi" "$work/now.abi" > "$work/report" || status=$?
[ $((status & 3)) = 0 ] || {
  cat "$work/report"
  echo "abidiff failed"
  exit 1
}
if [ $((status & 8)) != 0 ] || grep -q "^[1-9][0-9]* .*[Cc]hanged\|^  \[C\]" "$work/report"; then
  cat "$work/report"
  echo "FAILED: programs would have to be compiled again"
  exit 1
fi
echo "$functions functions match the recorded interface"
