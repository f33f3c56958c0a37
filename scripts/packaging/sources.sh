#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Prints a hash of the files that the libraries and programs are built from. Packages and wheels contain it, and
# scripts/prebuilt.sh compares it, because the version stays the same between releases.
set -eu
cd "$(dirname -- "$0")/../.."

find CMakeLists.txt CMakePresets.json common include kernels scripts/packaging tutorials -type f \
  ! -name '*.md' ! -name '*.jpg' ! -path '*/__pycache__/*' -print0 | LC_ALL=C sort -z | xargs -0 sha256sum | sha256sum |
  cut -d ' ' -f 1
