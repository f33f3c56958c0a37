#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds what is missing and passes all tests.
#
#   scripts/test.sh [CTEST-OPTION...]    for example -R Abi, or -L quick

arguments=any # ctest's
. "$(dirname -- "$0")/lib.sh"

phase "packages" install_packages
phase "configure, get upstream" configure
phase "build" build
phase "tests" ctest --preset release -j "$jobs" "$@"
