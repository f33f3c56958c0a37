#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Checks that the patch series can be applied twice without effect and fails with an error if it does not fit, and
# that corrupted archives are rejected. Every failure is one clear line and leaves no partial files. An interrupted
# configure leaves a CMake package with our version.
#
#   upstream.sh CMAKE ARCHIVE
set -eu
cmake=$1 archive=$2
here=$(cd -- "$(dirname -- "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r "$here/../../kernels/upstream" "$work/upstream"
cd "$work"

# provide ARCHIVE [CMAKE-OPTION...]: performs the steps of a configure, into $work/tree.
cat > provide.cmake << 'CMAKE'
include(${CMAKE_CURRENT_LIST_DIR}/upstream/upstream.cmake)
upstream_provide(${CMAKE_CURRENT_LIST_DIR}/tree)
CMAKE
provide() {
  file=$1
  shift
  "$cmake" -DEMBREE_UPSTREAM_ARCHIVE="$file" -DEMBREE_UPSTREAM_CACHE="$work/cache" "$@" -P provide.cmake
}
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
# refuses TEXT PROVIDE-ARGUMENT...: expects a failure with one line that contains the text, without a tree or other
# files.
refuses() {
  text=$1
  shift
  ! provide "$@" > log 2>&1 || fail "an invalid source is accepted: expected an error with \"$text\""
  grep -q "^ *upstream: .*$text" log || {
    cat log
    fail "the message does not contain \"$text\""
  }
  [ "$(grep -c 'upstream: ' log)" = 1 ] || {
    cat log
    fail "the message does not have one line: $text"
  }
  for left in tree* cache/.download* cache/*.part; do
    [ ! -e "$left" ] || fail "$left remains after the error \"$text\""
  done
  echo "rejected: $(grep -m 1 'upstream: ' log)"
}

lines=$(cat upstream/patches/*.patch | wc -l)
[ "$lines" -lt 800 ] || fail "the series has $lines lines"
echo "the series has $lines lines"
sed '/^#/d' upstream/patches/series | sort > named
(cd upstream/patches && printf "%s\n" *.patch | sort) > present
diff named present || fail "series and patches differ"

# Corrupted archives.
sum_of() { sha256sum "$1" | cut -d ' ' -f 1; }
sum=$(sum_of "$archive")
head -c 1000000 "$archive" > truncated.tar.xz
refuses "truncated.tar.xz.*$(sum_of truncated.tar.xz).*[^0-9]1000000 bytes.*$sum" "$work/truncated.tar.xz"
{
  cat "$archive"
  echo
} > longer.tar.xz
refuses "longer.tar.xz.*$(sum_of longer.tar.xz).*$sum" "$work/longer.tar.xz"
: > empty.tar.xz
refuses "empty.tar.xz.*$(sum_of empty.tar.xz).*[^0-9]0 bytes.*$sum" "$work/empty.tar.xz"
refuses "absent.tar.xz: .*such" "$work/absent.tar.xz"
refuses "$work/upstream: .*tree" "" -DEMBREE_UPSTREAM_SOURCE_DIR="$work/upstream"

# A registry that does not answer, and a registry with different data.
mkdir bin
printf '#!/bin/sh\necho "no answer" >&2\nexit 1\n' > bin/fetch.sh
cp upstream/fetch.sh kept.sh
install -m 755 bin/fetch.sh upstream/fetch.sh
(
  unset EMBREE_UPSTREAM_FALLBACK
  refuses "embree .*no answer" ""
)
printf '#!/bin/sh\necho other > "$3/embree.orig.tar.xz"\n' > bin/fetch.sh
install -m 755 bin/fetch.sh upstream/fetch.sh
refuses "$(echo other | sum_of -).*$sum" ""
mv kept.sh upstream/fetch.sh

# A series that does not fit, and a missing patch.
cp upstream/patches/subdiv-accel.patch kept
sed -i 's/^ #include "\.\.\/bvh\/bvh8_factory\.h"/ #include "..\/bvh\/bvh9_factory.h"/' \
  upstream/patches/subdiv-accel.patch
refuses "subdiv-accel.patch .*embree .*Hunk #1 FAILED" "$archive"
rm upstream/patches/subdiv-accel.patch
refuses "subdiv-accel.patch: .*series" "$archive"
mv kept upstream/patches/subdiv-accel.patch

# Applied twice: the second time must not touch any file.
contents() { find tree -type f -printf '%p %T@ ' -exec md5sum {} +; }
provide "$archive"
grep -q createCompressedAccel tree/kernels/common/scene.cpp || fail "the tree is not patched"
contents > once
provide "$archive"
contents > twice
cmp once twice || fail "applying twice changes the tree"

# A tree that was unpacked elsewhere must give the same result.
mkdir elsewhere
(cd elsewhere && "$cmake" -E tar xf "$archive")
mv tree first
provide "" -DEMBREE_UPSTREAM_SOURCE_DIR="$(echo "$work"/elsewhere/*)"
diff -r --exclude=.cbvh-stamp first tree || fail "EMBREE_UPSTREAM_SOURCE_DIR gives a different tree"
rm -rf tree first

# A different series: only changed files are written.
provide "$archive"
sed -i '/packet-masks/d' upstream/patches/series
touch -d '1 hour ago' mark
find tree -exec touch -d '2 hours ago' {} +
provide "$archive"
! grep -q OnlyActiveRays tree/kernels/common/rtcore.cpp || fail "the old patch is still applied"
changed=$(find tree -type f -newer mark ! -name .cbvh-stamp)
[ "$changed" = tree/kernels/common/rtcore.cpp ] ||
  fail "these files are written again: $changed: expected only rtcore.cpp"

# Interrupted after upstream has configured its files, before our files follow.
echo 'cmake_language(DEFER CALL message FATAL_ERROR "interrupted")' > interrupt.cmake
! "$cmake" -S "$here/../.." -B interrupted -DEMBREE_UPSTREAM_ARCHIVE="$archive" \
  -DCMAKE_PROJECT_embree3_INCLUDE="$work/interrupt.cmake" > log 2>&1 || fail "the configure was not interrupted"
grep -q interrupted log || {
  cat log
  fail "the configure failed by itself"
}
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:[^=]*=//p' interrupted/CMakeCache.txt)
grep -q "^SET(EMBREE_CBVH_VERSION $version)" interrupted/embree/embree-config-install.cmake ||
  fail "the CMake package of an interrupted configure lacks our version"
echo passed
