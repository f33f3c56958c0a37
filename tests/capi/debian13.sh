#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Runs libembree_cbvh as built here on Debian 13, or another RELEASE of Debian, next to its Embree 4: the tests of hits,
# both examples, the speed test, and reload; valgrind looks for leaks. Requires root, debootstrap, the machine's package
# registry and 1 GB of disk. Takes two minutes, or seconds if the root file system already exists.
#
#   debian13.sh BUILD-DIRECTORY DIRECTORY-FOR-THE-ROOT [RELEASE]
#
# RELEASE is trixie (default), testing or unstable.
set -eu
build=$(cd "$1" && pwd) roots=$2 release=${3:-trixie}
here=$(cd -- "$(dirname -- "$0")" && pwd)
. "$here/debian_root.sh"
install_in_root g++ libembree-dev valgrind
trap 'umount "$root/proc" 2>/dev/null || true' EXIT
mount --bind /proc "$root/proc" # for valgrind
work=$root/root/capi
rm -rf "$work"
mkdir -p "$work/include"
cp -rL "$build/include/cbvh" "$work/include/"
cp "$build"/kernels/capi/libembree_cbvh.so.1 "$here"/*.cpp "$here"/*.h "$here"/../../tutorials/capi/*.cpp \
  "$here"/../../tutorials/capi/*.h "$work/"
rm "$work/api.cpp" # requires our libembree3
compile="g++ -std=c++17 -O2 -Wall -Wextra -Werror -Iinclude"
inside() { chroot "$root" sh -c "cd /root/capi && $*"; }
for program in hits displaced_cage diced_grids speed; do
  inside "$compile $program.cpp -o $program ./libembree_cbvh.so.1 -lembree4 -Wl,-rpath,/root/capi" ||
    fail "$program does not compile"
  inside "./$program" || fail "$program fails on $release"
done
inside "$compile reload.cpp -o reload -lembree4" &&
  inside "./reload ./libembree_cbvh.so.1" || fail "reload does not compile or run"
for picture in displaced_cage diced_grids; do
  if [ -x "$build/tutorials/capi/$picture" ]; then
    "$build/tutorials/capi/$picture" "$work/here.pgm" > /dev/null
    cmp "$work/here.pgm" "$work/$picture.pgm" || fail "$picture differs next to Embree 4"
  fi
done
for program in ./displaced_cage "./reload ./libembree_cbvh.so.1"; do
  leaks="--leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite"
  if ! inside "valgrind -q --undef-value-errors=no $leaks --error-exitcode=1 $program" > "$roots/log" 2>&1; then
    grep -q "nrecogni[sz]ed instruction\|unhandled instruction" "$roots/log" ||
      {
        tail -n 30 "$roots/log"
        fail "valgrind finds errors in $program"
      }
    echo "valgrind does not support this processor's instructions"
  fi
done
echo "$release: passed"
