#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Tests an installation by `cmake --install`: programs that use find_package(embree 3) or pkg-config, and our own
# programs, also after it was moved.
#
#   test.sh CMAKE BUILD-DIRECTORY LIBRARY    LIBRARY is the machine's own Embree, 3.13 or 4
set -eu
cmake=$1 build=$2 host=$3
stock=$(dirname "$host")
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:[^=]*=//p' "$build/CMakeCache.txt")
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
here=$(cd -- "$(dirname -- "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$cmake" --install "$build" --prefix "$work/first" > "$work/log" || {
  cat "$work/log"
  exit 1
}
mv "$work/first" "$work/prefix"
unset LD_LIBRARY_PATH EMBREE_CBVH
[ -e "$work"/prefix/lib/libembree3.so.3 ]
for header in rtcore.h rtcore_compression.h rtcore_compression_version.h rtcore_surface.h cbvh.h; do
  [ -f "$work/prefix/include/embree3/$header" ]
done
if [ -e "$build/kernels/vulkan/libembree3_vulkan.so.3" ]; then
  [ -e "$work"/prefix/lib/libembree3_vulkan.so.3 ]
  [ -f "$work/prefix/include/embree3/rtcore_vulkan.h" ]
  [ -f "$work/prefix/include/embree3/cbvh.glsl" ]
  # comments contain the prefix only in names of functions
  ! grep -E '^ *(/?\*|//)' "$work/prefix/include/embree3/cbvh.glsl" | grep -E '\bcbvh_[a-z]+\b([^(]|$)' ||
    fail "these comments of cbvh.glsl contain prefixes"
  # it finds the library next to it
  ldd "$work/prefix/lib/libembree3_vulkan.so.3" | grep -q "libembree3.so.3 => $work/prefix/lib/"
fi
# A link into the source tree would break elsewhere.
for link in $(find "$work/prefix" -type l); do
  case $(readlink "$link") in
    */*)
      echo "$link leads out of the installation" >&2
      exit 1
      ;;
  esac
done

# All libraries and programs are hardened. Kernels are bound immediately. Programs and libraries that
# link libembree3 are not, because they must start with any version of it.
for binary in "$work"/prefix/lib/*.so.* "$work"/prefix/lib/embree_cbvh/*.so.* "$work"/prefix/bin/*; do
  [ -f "$binary" ] && [ ! -L "$binary" ] || continue
  readelf -Wldh "$binary" > "$work/elf"
  grep -q 'Type: *DYN' "$work/elf" || fail "$binary is not position independent"
  grep -q 'GNU_RELRO' "$work/elf" || fail "$binary has no RELRO"
  case ${binary##*/} in
    libembree3.so.* | libembree_cbvh.so.*)
      grep -Eq 'BIND_NOW|FLAGS.* NOW' "$work/elf" || fail "$binary is not bound immediately"
      ;;
  esac
  # Our programs print numbers. Release builds call the checked functions of the C library for that.
  case ${binary##*/} in
    cbvh_*) ! grep -q '^CMAKE_BUILD_TYPE:[^=]*=Release' "$build/CMakeCache.txt" ||
      nm -D --undefined-only "$binary" | grep -q '_chk' || fail "$binary does not use checked functions" ;;
  esac
done

cp "$here/CMakeLists.txt" "$here"/*.cpp "$work/"
# Without TBB's CMake files, which users of the shared library do not need.
"$cmake" -S "$work" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON \
  > "$work/log.configure" ||
  {
    cat "$work/log.configure"
    exit 1
  }
"$cmake" --build "$work/build" > "$work/log" || {
  cat "$work/log"
  exit 1
}
grep -q "Embree 3.13.5, of Embree CBVH $version\$" "$work/log.configure" ||
  {
    cat "$work/log.configure"
    fail "find_package does not find our version $version"
  }
library=$("$work/build/renderer")
case $library in
  "$work"/prefix/*) echo "runs on the installed library" ;;
  *)
    echo "runs on $library" >&2
    exit 1
    ;;
esac
if [ -e "$work/prefix/include/embree3/rtcore_vulkan.h" ]; then
  "$work/build/on_vulkan" || fail "find_package has no embree_vulkan that runs"
fi

# --- libembree_cbvh next to any Embree: a program that uses the machine's -------------------------------

[ -e "$work/prefix/lib/embree_cbvh/libembree_cbvh.so.1" ] || fail "libembree_cbvh is not installed"
for folder in $(PKG_CONFIG_PATH="$work/prefix/lib/pkgconfig" pkg-config --cflags-only-I --libs-only-L embree_cbvh); do
  [ -z "$(find "${folder#-?}" -name 'embree3*' -o -name 'libembree3*')" ] ||
    fail "pkg-config embree_cbvh leads to our Embree"
done
mkdir "$work/capi"
cp "$here/capi/CMakeLists.txt" "$here"/../../tutorials/capi/*.cpp "$here"/../../tutorials/capi/*.h "$work/capi/"
"$cmake" -S "$work/capi" -B "$work/capi/build" -DCMAKE_PREFIX_PATH="$work/prefix" -DHOST_EMBREE="$host" \
  > "$work/log" && "$cmake" --build "$work/capi/build" >> "$work/log" 2>&1 ||
  {
    cat "$work/log"
    fail "find_package has no embree_cbvh"
  }
(cd "$work/capi" && LD_LIBRARY_PATH="$stock" ./build/displaced_cage) ||
  fail "a program with libembree_cbvh does not run"
LD_LIBRARY_PATH="$stock" ldd "$work/capi/build/displaced_cage" | grep -q "libembree[34].so.[34] => $stock" ||
  fail "it runs on an Embree that is not the machine's"

# --- pkg-config -----------------------------------------------------------------------------------

export PKG_CONFIG_PATH="$work/prefix/lib/pkgconfig"
[ "$(pkg-config --modversion embree_cbvh)" = "$version" ] || fail "pkg-config has another version of libembree_cbvh"
[ "$(pkg-config --modversion embree3)" = 3.13.5 ] || fail "pkg-config has another version of Embree"
[ "$(pkg-config --variable=cbvh_version embree3)" = "$version" ] || fail "pkg-config has another version of ours"
# shellcheck disable=SC2046
c++ "$here/renderer.cpp" -o "$work/renderer" $(pkg-config --cflags --libs embree3) -ldl
library=$(LD_LIBRARY_PATH=$work/prefix/lib "$work/renderer")
case $library in "$work"/prefix/*) ;; *) fail "a program built with pkg-config runs on $library" ;; esac

# --- examples, compiled in place ------------------------------------------------------------------------

examples=$work/prefix/share/doc/embree-cbvh/examples
for example in displaced_cage diced_grids; do
  # shellcheck disable=SC2046
  c++ -std=c++17 "$examples/$example.cpp" $(pkg-config --cflags --libs embree_cbvh) "$host" \
    -o "$work/$example" ||
    fail "the installed example $example does not compile"
done
# shellcheck disable=SC2046
cc -std=c99 -Wall -Wextra -Werror -pedantic "$examples/displacement_map.c" $(pkg-config --cflags --libs embree_cbvh) \
  -lm -o "$work/displacement_map" ||
  fail "the installed example displacement_map does not compile"
(cd "$work" && LD_LIBRARY_PATH=$work/prefix/lib/embree_cbvh ./displacement_map) ||
  fail "the installed example displacement_map does not run"

# --- the codec, without any Embree ------------------------------------------------------------------

mkdir "$work/codec"
cp "$here/codec/CMakeLists.txt" "$examples"/codec/*.cpp "$work/codec/"
"$cmake" -S "$work/codec" -B "$work/codec/build" -DCMAKE_PREFIX_PATH="$work/prefix" > "$work/log" &&
  "$cmake" --build "$work/codec/build" >> "$work/log" 2>&1 ||
  {
    cat "$work/log"
    fail "find_package has no cvert"
  }
"$here/../codec/examples.sh" "$work/codec/build/encode_grid" "$work/codec/build/file_to_obj"
# The library can be linked by programs compiled for any instruction set.
"$cmake" -S "$work/codec" -B "$work/codec/wide" -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_CXX_FLAGS=-mavx2 \
  > "$work/log" && "$cmake" --build "$work/codec/wide" >> "$work/log" 2>&1 ||
  {
    cat "$work/log"
    fail "a program compiled with -mavx2 does not link cvert"
  }
! ldd "$work/codec/build/file_to_obj" | grep -iE "embree|tbb" || fail "the codec needs Embree or TBB"

# --- manual pages: one for each function of our headers ---------------------------------------------

functions=$(cd "$work/prefix/include/embree3" && sed -n 's/^RTC_[A-Z]* .*\(rtc[A-Z][A-Za-z]*\) *(.*/\1/p' \
  rtcore_compression.h rtcore_surface.h)
[ "$(echo "$functions" | wc -w)" -gt 5 ] || fail "few functions in our headers: $functions"
for function in $functions; do
  page=$work/prefix/share/man/man3/$function.3embree3
  [ -s "$page" ] || fail "$function has no manual page"
  grep -q "$function" "$page" || fail "$page does not name it"
done
functions=$(grep -o '^CBVH_API .*' "$work/prefix/include/embree_cbvh/cbvh/cbvh.h" | grep -o 'cbvh[A-Za-z0-9]*(')
[ "$(echo "$functions" | wc -w)" -gt 20 ] || fail "few functions in cbvh.h: $functions"
for function in $functions; do
  function=${function%(}
  [ -s "$work/prefix/share/man/man3/$function.3cbvh" ] || fail "$function has no manual page"
done
if command -v help2man > /dev/null; then
  for program in "$work"/prefix/bin/cbvh_*; do
    page=$work/prefix/share/man/man1/$(basename "$program").1
    option=level
    [ "$(basename "$program")" != cbvh_terrain ] || option=cell
    grep -qF -- "\\-\\-$option" "$page" || fail "$(basename "$program") has no manual page of its options"
  done
fi
for program in "$work"/prefix/bin/cbvh_*; do
  completion=$work/prefix/share/bash-completion/completions/$(basename "$program")
  grep -q -- ' --version' "$completion" || fail "$(basename "$program") has no completion of its options"
done
[ -e "$work/prefix/share/man/man3/rtcNewDevice.3embree3" ] || fail "Embree's own manual pages are missing"

# --- our programs use the library next to them, and report other libraries ------------------------

for program in "$work"/prefix/bin/cbvh_*; do
  "$program" --version > "$work/output" || fail "$program --version does not run"
  [ "$(head -n 1 "$work/output")" = "${program##*/} $version" ] ||
    {
      cat "$work/output"
      fail "$program --version: the first line is not \"${program##*/} $version\""
    }
  grep -q "^library: Embree CBVH $version on Embree 3.13.5, $work/prefix/" "$work/output" ||
    {
      cat "$work/output"
      fail "$program runs on a different library"
    }
  case $host in
    */libembree3.*)
      LD_LIBRARY_PATH=$stock "$program" --version > "$work/output" 2>&1 &&
        grep -q "^library: Embree 3.13.5, without compression, $stock/libembree3.so.3" "$work/output" ||
        {
          cat "$work/output"
          fail "$program does not start with Embree's library"
        }
      ;;
  esac
done
if [ -x "$work/prefix/bin/cbvh_render" ]; then
  render() { "$work/prefix/bin/cbvh_render" --scene cube --level 2 --size 16x16 --output "$work/pictures" "$@"; }
  render --representation cvert > "$work/output" 2>&1 || {
    cat "$work/output"
    fail "cbvh_render does not run"
  }
  case $host in
    */libembree3.*)
      ! LD_LIBRARY_PATH=$stock render --representation cvert > "$work/output" 2>&1 ||
        fail "cbvh_render compresses with Embree's library"
      grep -q "Embree 3.13.5.* $stock/libembree3.so.3.*LD_LIBRARY_PATH" "$work/output" ||
        {
          cat "$work/output"
          fail "cbvh_render does not name Embree's library and the remedy"
        }
      ;;
  esac
  tail -n 1 "$work/output"
fi
