#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds Debian packages in output/, for this release of Debian: libembree3-cbvh, libembree-cbvh-dev and
# embree-cbvh-tools, which replace Debian's libembree3-3, libembree-dev and embree-tools; libembree-cbvh0,
# libembree-cbvh0-dev and python3-embree-cbvh, which replace no package. Earlier packages in output/ are removed.
#
#   scripts/package.sh && apt install ./output/*.deb
#
# A distributor first sets the maintainer: cmake --preset package "-DCBVH_PACKAGE_MAINTAINER=NAME <ADDRESS>"

. "$(dirname -- "$0")/lib.sh"

phase "packages" install_packages
phase "configure, get upstream" configure package
phase "build" build package
rm -f build/package/packages/*.deb
phase "package" cmake --build --preset package --target package

mkdir -p output
rm -f output/*embree*cbvh*.deb
cp build/package/packages/*.deb output/
ls -l output/*.deb
