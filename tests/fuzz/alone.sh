#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds a fuzz target that does not require a library, in seconds, and runs it from its own seeds with libFuzzer,
# AddressSanitizer and UndefinedBehaviorSanitizer. Requires no prior configure or build.
#
#   alone.sh CLANG TARGET FOLDER SECONDS [SOURCE-OR-FLAG...]
#
# TARGET is the name of a source in this directory without .cpp. SOURCE is another file to compile into it; the
# codec's sources are always included. FOLDER keeps the program and its corpus. For longer runs with other seeds:
#
#   FOLDER/TARGET -max_total_time=3600 FOLDER/TARGET.corpus

set -eu
clang=$1 target=$2 folder=$3 seconds=$4
shift 4
root=$(cd "$(dirname "$0")/../.." && pwd)
corpus=$folder/$target.corpus
mkdir -p "$corpus"
# vptr requires type information of whole programs
"$clang" -std=c++17 -O1 -g1 -march=native -fno-strict-aliasing -fno-sanitize-recover=all \
  -fsanitize=fuzzer,address,undefined -fno-sanitize=vptr -I "$root" -I "$root/tests" \
  "$root/tests/fuzz/$target.cpp" "$root"/kernels/cvert/*/*.cpp "$@" -o "$folder/$target"
exec "$folder/$target" --seeds="$corpus" -seed=1 -max_len=65536 -timeout=20 -max_total_time="$seconds" \
  -print_final_stats=1 "$corpus"
