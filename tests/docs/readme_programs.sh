#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Extracts the C programs of README.md and docs/renderers.md, compiles them and runs them with an installation, as
# described on the pages: the first one with README's compile line and with the CMake lines of docs/renderers.md, the
# second one in a scene of Embree.
#
#   readme_programs.sh CMAKE BUILD-DIRECTORY SOURCE-DIRECTORY LIBRARY    LIBRARY is the machine's own Embree, 3.13 or 4
set -eu
cmake=$1 build=$2 source=$3 host=$4
page=$source/README.md renderers=$source/docs/renderers.md
case $host in */libembree4.*) version=4 ;; *) version=3 ;; esac
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset LD_LIBRARY_PATH EMBREE_CBVH PKG_CONFIG_PATH

# block LANGUAGE PAGE: prints the page's first code block in a language
block() {
  awk -v fence="\`\`\`$1" '$0 == fence { on = ++found == 1; next } /^```/ { on = 0 } on' "$2"
}

"$cmake" --install "$build" --prefix "$work/opt" > "$work/log" ||
  {
    cat "$work/log"
    fail "cmake does not install $build"
  }
cd "$work"
block c "$page" > first_ray.c
[ "$(wc -l < first_ray.c)" -le 15 ] && [ -s first_ray.c ] ||
  fail "the program has $(wc -l < first_ray.c) lines: expected 1 to 15"

# --- the page's compile line ------------------------------------------------------------------------

sed -n 's/^    \(export PKG_CONFIG_PATH=.*\)/\1/p; s/^    \(cc .*first_ray.*\)/\1/p
    s/^    \(.*\.\/first_ray\)$/\1/p' "$page" |
  sed "s|/opt/embree-cbvh|$work/opt|g" > commands
[ "$(wc -l < commands)" = 3 ] || fail "the page has $(wc -l < commands) lines that compile and run it: expected 3"
sed 's/ cc / cc -Wall -Wextra -Werror -pedantic /; s/^cc /cc -Wall -Wextra -Werror -pedantic /' commands > strict
output=$(sh -eu strict) || fail "the program does not compile and run"
echo "$output"
printed=$(sed -n 's/.*prints `\(distance [^`]*\)`.*/\1/p' "$page")
[ "$output" = "$printed" ] || fail "the program prints \"$output\", the page says \"$printed\""

# --- the CMake lines of docs/renderers.md ----------------------------------------------------------------

{
  echo 'cmake_minimum_required(VERSION 3.10)'
  echo 'project(first_ray C)'
  echo 'add_executable(renderer first_ray.c)'
  block cmake "$renderers"
  echo 'target_link_libraries(renderer m)'
} > CMakeLists.txt
"$cmake" -S . -B cmake -DCMAKE_PREFIX_PATH="$work/opt" > log 2>&1 && "$cmake" --build cmake >> log 2>&1 ||
  {
    cat log
    fail "the program does not build with the CMake lines of docs/renderers.md"
  }
[ "$(cmake/renderer)" = "$output" ] || fail "the output of the program built by CMake differs"

# --- the program of docs/renderers.md, in a scene of Embree ----------------------------------------------

export PKG_CONFIG_PATH="$work/opt/lib/pkgconfig" LD_LIBRARY_PATH="$work/opt/lib/embree_cbvh"
block c "$renderers" | sed "s|embree4/rtcore.h|embree$version/rtcore.h|" > whole.c
distance=$(sed -n 's/.*prints `\(face [^`]*\)`.*/\1/p' "$renderers")
[ -n "$distance" ] || fail "docs/renderers.md does not say what its program prints"
# shellcheck disable=SC2046
cc -std=c99 -Wall -Wextra -Werror whole.c $(pkg-config --cflags --libs embree_cbvh) "$host" -lm -o whole ||
  fail "the program of docs/renderers.md does not compile"
output=$(./whole)
[ "$output" = "$distance" ] || fail "the program of docs/renderers.md prints \"$output\", the page says \"$distance\""
ldd ./whole | sed -n 's/.*libembree[34].so.[34] => \([^ ]*\).*/\1/p' > library
[ "$(realpath "$(cat library)")" = "$(realpath "$host")" ] ||
  fail "the program runs on $(cat library), not on the machine's Embree"
