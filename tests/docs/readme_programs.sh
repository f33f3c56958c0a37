#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Extracts the code of README.md, compiles it and runs it with an installation, as described on the page: the C program
# with the page's compile line and with its CMake lines, and the lines for a scene of Embree. Then compiles and runs the
# program of docs/renderers.md for a scene of Embree.
#
#   readme_programs.sh CMAKE BUILD-DIRECTORY SOURCE-DIRECTORY LIBRARY    LIBRARY is the machine's own Embree, 3.13 or 4
set -eu
cmake=$1 build=$2 source=$3 host=$4
page=$source/README.md
case $host in */libembree4.*) version=4 ;; *) version=3 ;; esac
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset LD_LIBRARY_PATH EMBREE_CBVH PKG_CONFIG_PATH

# block LANGUAGE N: prints the page's Nth code block in a language
block() {
  awk -v fence="\`\`\`$1" -v n="$2" '$0 == fence { on = ++found == n; next } /^```/ { on = 0 } on' "$page"
}

"$cmake" --install "$build" --prefix "$work/opt" > "$work/log" ||
  {
    cat "$work/log"
    fail "cmake does not install $build"
  }
cd "$work"
block c 1 > first_ray.c
[ "$(wc -l < first_ray.c)" -le 25 ] && [ -s first_ray.c ] ||
  fail "the program has $(wc -l < first_ray.c) lines: expected 1 to 25"

# --- the page's compile line ------------------------------------------------------------------------

sed -n 's/^    \(export PKG_CONFIG_PATH=.*\)/\1/p; s/^    \(cc .*first_ray.*\)/\1/p' "$page" |
  sed "s|/opt/embree-cbvh|$work/opt|g" > commands
[ "$(wc -l < commands)" = 2 ] || fail "the page has $(wc -l < commands) lines that compile the program: expected 2"
sed 's/ cc / cc -Wall -Wextra -Werror -pedantic /; s/^cc /cc -Wall -Wextra -Werror -pedantic /' commands > strict
output=$(sh -eu strict) || fail "the program does not compile and run"
echo "$output"
# The ray goes down at x = 0.1 and hits face 1, the upper one, at a height between 0 and 1.
echo "$output" | grep -qE '^face 1, distance 3\.[0-9]+$' || fail "the program prints: $output"

# --- the page's CMake lines ---------------------------------------------------------------------------

{
  echo 'cmake_minimum_required(VERSION 3.10)'
  echo 'project(first_ray C)'
  block cmake 1
} > CMakeLists.txt
"$cmake" -S . -B cmake -DCMAKE_PREFIX_PATH="$work/opt" > log 2>&1 && "$cmake" --build cmake >> log 2>&1 ||
  {
    cat log
    fail "the program does not build with the CMake lines of the page"
  }
[ "$(cmake/first_ray)" = "$output" ] || fail "the output of the program built by CMake differs"

# --- in a scene of Embree ----------------------------------------------------------------------------

# Completes the lines with the device, scene and group of the first program.
block c 2 | sed "s|embree4/rtcore.h|embree$version/rtcore.h|" > lines
grep '^#include' lines > in_scene.c
sed '/^#include <cbvh/d; s/^int main(void)/static CbvhGroup groupOfTheFirstProgram(void)/
     s/return fprintf\(.*\), 1;/return fprintf\1, NULL;/
     s/^  struct CbvhRayHit ray.*/  return group;/; /^  if (cbvhIntersect1/d' first_ray.c >> in_scene.c
cat >> in_scene.c << 'EOF'
int main(void) {
  RTCDevice device = rtcNewDevice(NULL);
  RTCScene scene = rtcNewScene(device);
  CbvhGroup group = groupOfTheFirstProgram();
EOF
grep -v '^#include' lines >> in_scene.c
cat >> in_scene.c << 'EOF'
  rtcCommitScene(scene);
  struct RTCRayHit ray = {.ray = {.org_x = 0.1f, .org_z = 4, .dir_z = -1, .tfar = INFINITY, .mask = ~0u},
                          .hit = {.geomID = ~0u}};
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &ray, NULL);
#else
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray);
#endif
  if (ray.hit.geomID == 0) printf("face %u, distance %g\n", ray.hit.primID, ray.ray.tfar);
}
EOF
export PKG_CONFIG_PATH="$work/opt/lib/pkgconfig" LD_LIBRARY_PATH="$work/opt/lib/embree_cbvh"
# shellcheck disable=SC2046
cc -std=c99 in_scene.c $(pkg-config --cflags --libs embree_cbvh) "$host" -lm -o in_scene
[ "$(./in_scene)" = "$output" ] || fail "the hit in a scene of Embree differs"
# on_host PROGRAM: fails if the program does not load the machine's Embree
on_host() {
  ldd "$1" | sed -n 's/.*libembree[34].so.[34] => \([^ ]*\).*/\1/p' > library
  [ "$(realpath "$(cat library)")" = "$(realpath "$host")" ] ||
    fail "$1 runs on $(cat library), not on the machine's Embree"
}
on_host ./in_scene

# --- the program of docs/renderers.md -----------------------------------------------------------------

page=$source/docs/renderers.md
block c 1 | sed "s|embree4/rtcore.h|embree$version/rtcore.h|" > whole.c
distance=$(sed -n 's/.*prints `\(face [^`]*\)`.*/\1/p' "$page")
[ -n "$distance" ] || fail "docs/renderers.md does not say what its program prints"
# shellcheck disable=SC2046
cc -std=c99 -Wall -Wextra -Werror whole.c $(pkg-config --cflags --libs embree_cbvh) "$host" -lm -o whole ||
  fail "the program of docs/renderers.md does not compile"
output=$(./whole)
[ "$output" = "$distance" ] || fail "the program of docs/renderers.md prints \"$output\", the page says \"$distance\""
on_host ./whole
