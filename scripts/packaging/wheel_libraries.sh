#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds OpenImageIO and libtiff for a Python wheel, from Debian's source packages, and gets the headers of pybind11 and
# of further versions of CPython.
#
#   wheel_libraries.sh DIRECTORY [JOBS]    installs into DIRECTORY/prefix, and unpacks headers to DIRECTORY/trixie and
#                                          DIRECTORY/forky
#
# Debian's OpenImageIO needs 250 libraries of 420 MB, among them FFmpeg, GDAL, OpenCV and OpenVDB. This one reads and
# writes TIFF, OpenEXR, PNG, JPEG, Radiance HDR, BMP and PNM. It is a static library whose symbols are hidden, so that
# it does not clash with another OpenImageIO in a Python process. Debian's libtiff needs JBIG-KIT, whose license is the
# GPL; this one does not read JBIG and WebP inside of TIFF.
set -eu
here=$(cd -- "$(dirname -- "$0")" && pwd)
mkdir -p "$1"
work=$(cd -- "$1" && pwd)
jobs=${2:-$(nproc)}
prefix=$work/prefix
. "$here/../private_apt.sh"

# unpack PACKAGE VERSION SUITE SHA256: downloads the source package, and unpacks it to PACKAGE. Debian 12's own
# openimageio is older.
unpack() {
  package=$1 version=$2 suite=$3 sum=$4
  [ ! -e "$work/$package" ] || return 0
  mkdir -p "$work/archives" "$work/$package.part"
  set -- "$work/archives/${package}_$version".orig.tar.*
  if [ ! -e "$1" ]; then
    echo "downloading $package $version"
    "$here/../../kernels/upstream/fetch.sh" "$package" "$version" "$work/archives" "$suite" > "$work/log" 2>&1 ||
      {
        tail -n 1 "$work/log" >&2
        return 1
      }
    set -- "$work/archives/${package}_$version".orig.tar.*
  fi
  found=$(sha256sum "$1")
  [ "${found%% *}" = "$sum" ] ||
    {
      echo "$1: SHA-256 is ${found%% *}, expected $sum" >&2
      return 1
    }
  tar -xf "$1" -C "$work/$package.part" --strip-components=1
  mv "$work/$package.part" "$work/$package"
}

# install PACKAGE OPTION...: configures, builds and installs
install() {
  package=$1
  shift
  cmake -G Ninja -S "$work/$package" -B "$work/$package-build" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_C_FLAGS_RELEASE="-O2 -DNDEBUG" -DCMAKE_CXX_FLAGS_RELEASE="-O2 -DNDEBUG" \
    -DCMAKE_C_COMPILER_LAUNCHER="$(command -v ccache)" -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache)" \
    -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_PREFIX_PATH="$prefix" "$@" \
    > "$work/log" 2>&1 ||
    {
      tail -n 30 "$work/log" >&2
      return 1
    }
  cmake --build "$work/$package-build" -j "$jobs" --target install > "$work/log" 2>&1 ||
    {
      tail -n 30 "$work/log" >&2
      return 1
    }
  echo "built $package"
}

# unpack_headers SUITE PACKAGE...: downloads packages of another release, which are not installed, and unpacks them to
# SUITE. apt checks their signatures.
unpack_headers() {
  suite=$1
  shift
  [ ! -e "$work/$suite" ] || return 0
  apt=$work/apt
  rm -rf "$apt" "$work/$suite.part"
  echo "downloading $*"
  { private_apt_update "$(dpkg --print-architecture)" "$suite" 'Codename: bookworm' &&
    (cd "$apt" && private_apt apt-get download "$@"); } > "$work/log" 2>&1 ||
    {
      tail -n 5 "$work/log" >&2
      return 1
    }
  for file in "$apt"/*.deb; do
    dpkg -x "$file" "$work/$suite.part"
  done
  mv "$work/$suite.part" "$work/$suite"
  rm -rf "$apt"
}

# A module for another version of CPython requires only its headers. Debian 12's pybind11 supports neither NumPy 2 nor
# Python 3.13; Debian 13's also supports Python 3.14, which Debian 14 will have.
unpack_headers trixie pybind11-dev libpython3.13-dev
unpack_headers forky libpython3.14-dev

unpack tiff 4.5.0 bookworm 638f43d7dea33948d5dee7f39572fc0194d9cc3c74195de9dd26a4388a1f880a
install tiff -DBUILD_SHARED_LIBS=ON -Djbig=OFF -Dwebp=OFF -Djpeg12=OFF -Dcxx=OFF \
  -Dtiff-tools=OFF -Dtiff-tests=OFF -Dtiff-contrib=OFF -Dtiff-docs=OFF

unpack openimageio 2.5.18.0+dfsg trixie 0dc2185aac5e01a2e5a1a804f558c1190ea048650a7fedef1033a1616abcac80
# Algorithms on images take most of the time to compile, and the linker drops them.
unused='_(yee|compare|orient|addsub|muldiv|mad|minmaxchan|deep|xform|channels)'
sed -i -E "/^set \(libOpenImageIO_srcs/,/\)/{
  s/imagebufalgo$unused\.cpp//g
  s/(maketexture|printinfo)\.cpp//
  s/^set \(libOpenImageIO_srcs( *)\$/set (libOpenImageIO_srcs /
}" "$work/openimageio/src/libOpenImageIO/CMakeLists.txt"
set --
for package in Freetype OpenColorIO OpenCV TBB DCMTK FFmpeg GIF Libheif LibRaw OpenJPEG OpenVDB Ptex WebP QT Nuke \
  R3DSDK libjpeg-turbo PYTHON; do
  set -- "$@" "-DUSE_$package=OFF"
done
for format in cineon dds dpx fits ico iff null psd rla sgi softimage targa term zfile; do
  set -- "$@" "-DENABLE_$format=OFF"
done
install openimageio -DBUILD_SHARED_LIBS=OFF -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DCMAKE_CXX_STANDARD=17 \
  -DCMAKE_C_VISIBILITY_PRESET=hidden -DCMAKE_CXX_VISIBILITY_PRESET=hidden -DCMAKE_VISIBILITY_INLINES_HIDDEN=ON \
  -DCMAKE_CXX_FLAGS="-ffunction-sections -fdata-sections" -DUSE_STD_FILESYSTEM=ON -DUSE_CCACHE=OFF \
  -DCMAKE_UNITY_BUILD=ON -DOIIO_BUILD_TOOLS=OFF -DOIIO_BUILD_TESTS=OFF -DBUILD_TESTING=OFF -DBUILD_DOCS=OFF \
  -DINSTALL_DOCS=OFF -DINSTALL_FONTS=OFF -DBUILD_MISSING_ROBINMAP=OFF -DBUILD_MISSING_FMT=OFF -DINTERNALIZE_FMT=ON "$@"
