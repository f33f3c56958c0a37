#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# exports.sh LIBRARY HEADER: checks that libembree_cbvh exports exactly the functions of its header, with a symbol
# version, and requires no functions of Embree. odd_calls.cpp must call each function except cbvhGetVersion.
set -eu
library=$1 header=$2
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
exported=$(nm -D --defined-only "$library" | awk '$2 == "T" { sub(/@.*/, "", $3); print $3 }' | sort)
declared=$(grep -o '^CBVH_API .*' "$header" | grep -o 'cbvh[A-Za-z0-9]*(' | tr -d '(' | sort)
[ "$exported" = "$declared" ] ||
  fail "exported and declared differ: $(printf '%s\n%s\n' "$exported" "$declared" | sort | uniq -u | tr '\n' ' ')"
nm -D --defined-only "$library" | awk '$2 != "T" && $2 != "A" { exit 1 }' ||
  fail "it exports symbols other than functions"
nm -D --defined-only "$library" | grep -q 'cbvhIntersect1@@CBVH_' || fail "symbols have no version"
nm -D --undefined-only "$library" | grep -q ' rtc' && fail "it requires functions of Embree"
for function in $declared; do
  [ "$function" = cbvhGetVersion ] || grep -q "$function(" "$(dirname -- "$0")/odd_calls.cpp" ||
    fail "odd_calls.cpp does not call $function"
done
readelf -d "$library" | grep -q 'SONAME.*libembree_cbvh.so.1' || fail "the SONAME is not libembree_cbvh.so.1"
echo "exported: $(echo "$exported" | wc -l) functions"
