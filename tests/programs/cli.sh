# shellcheck shell=bash
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Functions that the command-line tests share. Source this file with $program set.

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export XDG_CACHE_HOME=$folder/cache
export XDG_RUNTIME_DIR=$folder # if it is not set, libwayland prints an error where GLFW 3.4 looks for a display
failures=0

# A cage of one quad with texture coordinates.
cat > "$folder/quad.obj" << OBJ
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

complain() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# expect_refusal PATTERN ARGUMENT...: expects status 1, and one matching line on stderr.
expect_refusal() {
  local pattern=$1
  shift
  "$program" "$@" > "$folder/stdout" 2> "$folder/stderr"
  local status=$?
  [ $status = 1 ] || complain "exit status $status: $*"
  grep -q "$pattern" "$folder/stderr" || complain "no '$pattern' in '$(cat "$folder/stderr")': $*"
  local lines
  lines=$(grep -vc '^  ' "$folder/stderr") # progress is indented
  [ "$lines" = 1 ] || complain "$lines lines on stderr, '$(cat "$folder/stderr")': $*"
}

# expect_cancellation READY ARGUMENT...: sends Ctrl-C to the program once the command READY succeeds. Expects status 130
# and a message.
expect_cancellation() {
  local ready=$1 process status
  shift
  "$program" "$@" > /dev/null 2> "$folder/stderr" &
  process=$!
  for _ in $(seq 1200); do
    eval "$ready" && break
    sleep 0.05
  done
  kill -INT $process
  wait $process
  status=$?
  [ $status = 130 ] || complain "exit status $status after Ctrl-C: $(tail -n 3 "$folder/stderr")"
  grep -q "^$(basename -- "$program"): canceled" "$folder/stderr" || complain "no message about the cancellation"
}

# Reports the result of the test and ends it.
finish() {
  [ $failures = 0 ] && echo "passed"
  exit $((failures != 0))
}
