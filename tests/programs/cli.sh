# shellcheck shell=bash
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Functions that the command-line tests share. Source this file with $program set.

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export XDG_CACHE_HOME=$folder/cache
failures=0

# A cage of one quad with texture coordinates.
cat >"$folder/quad.obj" <<OBJ
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
f 1/1 2/2 3/3 4/4
OBJ

complain() { echo "FAILED: $*"; failures=$((failures + 1)); }

# expect_refusal PATTERN ARGUMENT...: expects a failure that is not a signal, and one matching line on stderr.
expect_refusal() {
  local pattern=$1
  shift
  "$program" "$@" >"$folder/stdout" 2>"$folder/stderr"
  local status=$?
  [ $status -ge 1 ] && [ $status -lt 126 ] || complain "exit status $status: $*"
  grep -q "$pattern" "$folder/stderr" || complain "no '$pattern' in '$(cat "$folder/stderr")': $*"
  local lines
  lines=$(grep -vc '^  ' "$folder/stderr") # progress is indented
  [ "$lines" = 1 ] || complain "$lines lines on stderr, '$(cat "$folder/stderr")': $*"
}
