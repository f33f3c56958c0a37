#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds Debian packages in output/, for this release of Debian: libembree3-cbvh, libembree-cbvh-dev and
# embree-cbvh-tools, which replace Debian's libembree3-3, libembree-dev and embree-tools; libembree-cbvh1,
# libembree-cbvh1-dev and python3-embree-cbvh, which replace no package. Earlier packages in output/ are removed.
#
#   scripts/package.sh && apt install ./output/*.deb
#   scripts/package.sh arm64      cross-builds the packages for ARM64, in build/package-arm64/packages
#
# A distributor first sets the maintainer: cmake --preset package "-DCBVH_PACKAGE_MAINTAINER=NAME <ADDRESS>"
#
# The cross build installs Debian's cross compiler and emulator. It takes the libraries for ARM64 from the folder
# CBVH_ARM64_ROOT, or else from build/arm64-root, which scripts/arm64_root.sh fills on the first run.

arguments=1
. "$(dirname -- "$0")/lib.sh"

cross_packages() {
  for program in aarch64-linux-gnu-g++ qemu-aarch64-static; do
    command -v $program || {
      run_apt install g++-aarch64-linux-gnu qemu-user-static
      return
    }
  done
}

arm64_root() {
  if [ -d "$CBVH_ARM64_ROOT/DEBIAN" ]; then
    echo "$CBVH_ARM64_ROOT is present"
    return
  fi
  scripts/arm64_root.sh "$CBVH_ARM64_ROOT"
}

case ${1:-} in
  '') preset=package ;;
  arm64) preset=package-arm64 ;;
  *) usage_error "unknown architecture \"$1\": expected arm64, or none for this machine's" ;;
esac

phase "packages" install_packages
if [ "$preset" = package-arm64 ]; then
  export CBVH_ARM64_ROOT="${CBVH_ARM64_ROOT:-$root/build/arm64-root}"
  phase "cross compiler" cross_packages
  phase "libraries for ARM64" arm64_root
fi
phase "configure, get upstream" configure $preset
phase "build" build $preset
packages=build/$preset/packages
rm -f "$packages"/*.deb
phase "package" cmake --build --preset $preset --target package

if [ "$preset" = package ]; then
  mkdir -p output
  rm -f output/*embree*cbvh*.deb
  cp "$packages"/*.deb output/
  packages=output
fi
ls -l "$packages"/*.deb
