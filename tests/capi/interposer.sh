#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Tests the interposer on Debian 13: runs Debian's programs of Embree 4 and OSPRay with and without it. Their pictures
# must match except for the rounding to the lattice. Prints a table of differing pixels and peak memory.
#
#   interposer.sh BUILD-DIRECTORY [DIRECTORY-FOR-THE-ROOT [RELEASE]]
#
# With a folder for the root file system, the script has the requirements of debian13.sh, and takes four minutes, or two
# if the root file system already exists. RELEASE is trixie (default, Embree 4.3), testing or unstable (Embree 4.4).
# Without the folder, the script tests the interposer of the build on this machine. It then exits with 77 if the
# programs are missing, and leaves OSPRay out if libospray-dev is missing.
set -eu
build=$(cd "$1" && pwd) roots=${2:-} release=${3:-trixie}
here=$(cd -- "$(dirname -- "$0")" && pwd)
. "$here/debian_root.sh"

# $work is the folder of all files, $there the same folder as seen by the programs.
if [ -n "$roots" ]; then
  install_in_root g++ libembree-dev embree-tools libospray-dev time
  system=$root there=/root/interposer
  work=$root$there
  rm -rf "$work"
  inside() { chroot "$root" sh -c "cd $there && $*"; }
else
  for program in embree_displacement_geometry /usr/bin/time; do
    command -v "$program" > /dev/null ||
      {
        echo "skipped: no $program, see embree-tools and time in scripts/packages"
        exit 77
      }
  done
  unset LD_LIBRARY_PATH EMBREE_CBVH
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  system='' there=$work
  inside() { (cd "$work" && sh -c "$*"); }
fi
mkdir -p "$work/include" "$work/kernels/interposer" "$work/tests/interposer"
cp -rL "$build/include/cbvh" "$work/include/"
cp "$build/kernels/capi/libembree_cbvh.so.1" "$here"/../../kernels/interposer/*.cpp \
  "$here"/../../kernels/interposer/*.h "$here"/../../kernels/cbvh/operations/*.h \
  "$here"/../../kernels/cbvh/operations/device_string.cpp "$here"/../../kernels/cbvh/base/environment.h \
  "$here"/../../kernels/cbvh/base/grid_bytes.h "$work/"
cp "$here/../../kernels/interposer/functions.h" "$work/kernels/interposer/"
cp "$here/host.h" "$work/tests/"
cp "$here"/interposer/* "$work/tests/interposer/"
flags="-O2 -Wall -Wextra -Werror -Iinclude"

if [ -n "$roots" ]; then
  # The same command as in its CMakeLists.txt, which requires Embree 4 and therefore does nothing on Debian 12. $ORIGIN
  # must not be expanded by the shell in the other Debian.
  links="./libembree_cbvh.so.1 '-Wl,-rpath,\$ORIGIN' -Wl,-Bsymbolic-functions -Wl,--no-undefined"
  shared="$flags -fPIC -shared -fvisibility=hidden -DRTC_EXPORT_API"
  inside "g++ -std=c++17 $shared *.cpp -o libembree_cbvh_interposer.so $links" ||
    fail "the interposer does not compile"
  interposer=$there/libembree_cbvh_interposer.so
else
  interposer=$build/kernels/interposer/libembree_cbvh_interposer.so
fi
preload=LD_PRELOAD=$interposer
for program in calls horayzon moonray nearest points collisions; do
  inside "g++ -std=c++17 $flags tests/interposer/$program.cpp -o $program -lembree4 -ldl" ||
    fail "$program does not compile"
done
inside "g++ -std=c++17 $flags -I. tests/interposer/functions.cpp -o functions -ldl" &&
  inside "g++ -std=c++17 $flags tests/interposer/differ.cpp -o differ" &&
  inside "g++ -std=c++17 $flags -fPIC -shared tests/interposer/early.cpp -o libearly.so -lembree4" &&
  inside "echo 'int main() {}' | g++ -x c++ - -o early -L. -Wl,--no-as-needed -learly -Wl,-rpath,$there" ||
  fail "the programs do not compile"
# With traversables, that is, from Embree 4.4 on, the programs also run with libraries that make Embree behave as if
# another compiler had built it. `uses` are combinations of such a library and an argument of the programs.
uses=none, traversables=
if grep -q rtcGetSceneTraversable "$system/usr/include/embree4/rtcore_scene.h"; then
  for bound in BOUND_USER_DATA BOUND_QUERIES; do
    inside "g++ -std=c++17 $flags -D$bound -fPIC -shared tests/interposer/bound.cpp -o lib$bound.so -ldl" ||
      fail "the library with bound functions does not compile"
    uses="$uses $bound, $bound,traversables"
  done
  uses="$uses none,traversables" traversables=yes
fi
ospray=
if [ -e "$system/usr/include/ospray/ospray.h" ]; then
  ospray=yes
  inside "g++ $flags -x c tests/interposer/ospray.c -o picture -lospray" ||
    fail "the program for OSPRay does not compile"
fi

# --- functions: the interposer must know all functions of the headers --------------------------
inside "./functions $interposer /usr/include/embree4" || fail "kernels/interposer/functions.h is not complete"

# --- calls, horayzon, moonray: hits stored without the interposer must match those with it -----
inside "./calls hits > /dev/null" || fail "the calls fail without the interposer"
for use in $uses; do
  bound=${use%,*} argument=${use#*,}
  [ "$bound" = none ] && libraries=$interposer || libraries=$interposer:$there/lib$bound.so
  inside "LD_PRELOAD=$libraries EMBREE_CBVH=1,verbose,max_error=0.00001 ./calls hits $argument > calls.log 2>&1" ||
    {
      grep -v '^compression' "$work/calls.log"
      fail "hits differ ($use)"
    }
  [ "$(grep -c ': 40000 quads' "$work/calls.log")" -eq 3 ] ||
    fail "not all of grids, quads and triangles are compressed"
  grep -q ': 726 quads' "$work/calls.log" || fail "a moving cube is not compressed after a rejected time range"
  grep -q ': 2166 quads' "$work/calls.log" && fail "a cube of an unknown device is compressed"
  [ -z "$traversables" ] || [ "$(grep -c ': 1734 quads' "$work/calls.log")" -eq 2 ] ||
    fail "a cube with buffers of the device is not compressed"
  # Counts of compressed geometries: grids, quads and triangles, each twice; balls of quads
  for check in 'horayzon 36411 6' 'moonray 9600 15'; do
    # shellcheck disable=SC2086
    set -- $check
    [ -e "$work/$1.hits" ] || inside "./$1 $1.hits > /dev/null" || fail "$1 fails without the interposer"
    inside "LD_PRELOAD=$libraries EMBREE_CBVH=1,verbose,max_error=0.00001 ./$1 $1.hits $argument > $1.log 2>&1" ||
      {
        grep -v '^compression' "$work/$1.log"
        fail "hits of $1 differ ($use)"
      }
    [ "$(grep -c ": $2 quads" "$work/$1.log")" -eq "$3" ] || fail "not all of $1's surfaces are compressed ($use)"
  done
  inside "LD_PRELOAD=$libraries EMBREE_CBVH=1,verbose ./points $argument > points.log 2>&1" ||
    {
      cat "$work/points.log"
      fail "calls of point queries differ ($use)"
    }
  grep -q 'compression: 1 subdivision surface' "$work/points.log" ||
    fail "no surface of the point queries is compressed ($use)"
  inside "LD_PRELOAD=$libraries EMBREE_CBVH=1,verbose ./nearest $argument > nearest.log 2>&1" ||
    {
      cat "$work/nearest.log"
      fail "closest points differ ($use)"
    }
  [ "$(grep -c ': 3600 quads' "$work/nearest.log")" -eq 6 ] ||
    fail "not all of grids, quads and triangles of the closest points are compressed ($use)"
done
inside "$preload EMBREE_CBVH=1 ./calls hits" && inside "$preload EMBREE_CBVH=1 ./moonray moonray.hits" ||
  fail "hits differ with the default precision"
for reason in 'subdivision surface is left to Embree: RTC_SUBDIVISION_MODE_NO_BOUNDARY' 'its grids are so small' \
  'triangle mesh is left to Embree: it has RTC_BUILD_QUALITY_REFIT'; do
  [ "$(grep -c "$reason" "$work/calls.log")" -eq 1 ] || fail "must be reported exactly once: $reason"
done
inside "$preload EMBREE_CBVH=1,verbose,grids=0,quads=0,triangles=0 ./calls hits > calls.log 2>&1" ||
  fail "hits differ without compression of grids, quads and triangles"
grep -q ': 40000 quads' "$work/calls.log" && fail "grids, quads or triangles are compressed, which are turned off"
inside "$preload EMBREE_CBVH=1 ./calls hits 2>&1 > /dev/null" | grep 'is left to Embree' &&
  fail "what is left to Embree must be reported only with verbose"
for settings in unset 0 max_error=0.1,verbose; do
  [ "$settings" = unset ] && environment= || environment=EMBREE_CBVH=$settings
  inside "$preload $environment ./calls hits > calls.log 2>&1" || fail "hits differ without compression ($settings)"
  grep 'compression:' "$work/calls.log" && fail "compression must be off ($settings)"
done
inside "EMBREE_CBVH=grids=1,nonsense $preload ./calls hits 2> nonsense.log > /dev/null" ||
  fail "hits differ with an unknown setting"
[ "$(grep -c '"nonsense"' "$work/nonsense.log")" -eq 1 ] ||
  {
    cat "$work/nonsense.log"
    fail "the unknown setting must be reported exactly once"
  }
for settings in leaf,frame_level=2,verbose cLEAF,verbose tile,verbose cVERT,verbose 0,1,verbose none,vert,verbose \
  1,verbose=1; do
  inside "EMBREE_CBVH=$settings $preload ./calls hits 2>&1 > /dev/null" | grep -q 'quads' ||
    fail "settings without effect turn compression off: $settings"
done

# --- early: a library calls Embree before the interposer's static initializers run -------------
inside "./early" || fail "the program with an early library fails without the interposer"
inside "$preload EMBREE_CBVH=1 ./early" || fail "the program with an early library fails"

# --- points, collisions: the interposer must hide that surfaces are user geometry ---------------
inside "./points" && inside "./nearest" ||
  fail "Embree's calls of point queries differ from those that the test expects"
inside "$preload EMBREE_CBVH=1 ./points without-function" || fail "a query without a function fails"
inside "$preload EMBREE_CBVH=1 ./collisions" || fail "collisions differ"

# --- pictures ------------------------------------------------------------------------------------
# row NAME OPTIONS PROGRAM: renders a picture both ways and prints a row of the table. PROGRAM contains PICTURE in
# place of the file name.
row() {
  name=$1 options=$2 program=$3
  for way in without with; do
    [ $way = with ] && environment="$preload EMBREE_CBVH=$options" || environment=
    command=$(echo "$program" | sed "s/PICTURE/$way.ppm/")
    inside "env $environment /usr/bin/time -o $way.time -f '%M %e' $command > $way.log 2>&1" ||
      {
        cat "$work/$way.log"
        fail "$name fails $way the interposer"
      }
    awk '$1 !~ /^[0-9]+$/ { exit 1 }' "$work/$way.time" ||
      {
        cat "$work/$way.time"
        fail "$name, $way the interposer: time does not report memory and seconds"
      }
  done
  if grep -q 'libembree_cbvh_interposer' "$work/with.log"; then note="partly left to Embree"; else note=; fi
  differing=$(inside "./differ without.ppm with.ppm") || fail "the picture of $name differs: $differing"
  awk -v name="$name" -v differing="$differing" -v note="$note" '{ peak[NR] = $1/1024; seconds[NR] = $2 }
    END {
      printf "| %-36s | %22s | %7.1f | %7.1f | %5.2f | %5.2f | %s\n",
        name, differing, peak[1], peak[2], seconds[1], seconds[2], note
    }' "$work/without.time" "$work/with.time"
}

echo "| picture                              | pixels that differ, >8 | MiB     | with    | s     | with  |"
echo "|:-------------------------------------|-----------------------:|--------:|--------:|------:|------:|"
if [ -n "$ospray" ]; then
  for renderer in ao scivis pathtracer; do row "OSPRay, $renderer" 1,verbose "./picture $renderer 200 PICTURE"; done
  row "OSPRay, colors of vertices" 1,verbose "./picture ao 200 PICTURE colors"
  row "OSPRay, colors of faces" 1,verbose "./picture pathtracer 200 PICTURE faces"
  row "OSPRay, texture" 1,verbose "./picture pathtracer 200 PICTURE texcoords"
  row "OSPRay, next to user geometry" 1,verbose "./picture scivis 200 PICTURE boxes"
  row "OSPRay, instances" 1,verbose "./picture scivis 200 PICTURE instances"
  row "OSPRay, 24 million quads" 1,verbose "./picture scivis 2000 PICTURE"
  row "OSPRay, 24 million quads, texture" 1,verbose "./picture pathtracer 2000 PICTURE texcoords"
  grep -q '24000000 quads' "$work/with.log" || fail "OSPRay's cube is not compressed"
else
  echo "OSPRay is left out: no libospray-dev"
fi
for tutorial in displacement_geometry displacement_geometry_ispc subdivision_geometry subdivision_geometry_ispc; do
  row "$tutorial" 1,verbose "embree_$tutorial --size 512 512 -o PICTURE"
  grep -q 'compression: 1 subdivision surface' "$work/with.log" || fail "$tutorial is not compressed"
done
row grid_geometry 1,verbose "embree_grid_geometry --size 512 512 -o PICTURE"
for tutorial in interpolation motion_blur_geometry dynamic_scene user_geometry lazy_geometry intersection_filter \
  instanced_geometry; do
  row "$tutorial, mostly small" 1,verbose "embree_$tutorial --size 512 512 -o PICTURE"
done
models=$(cd "$system/usr/share/doc/embree4/models" && ls subdiv?.ecs subdiv_*.ecs grid4x4*.ecs | grep -v subdiv5)
for model in $models; do
  row "viewer, $model" 1,verbose "embree_viewer -c /usr/share/doc/embree4/models/$model --size 512 512 -o PICTURE"
done
echo "interposer: passed"
