#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds a Python wheel in output/, for CPython 3.11, 3.13 and 3.14 on systems with glibc 2.36 or newer, and removes
# earlier wheels there. It contains the module, libembree_cbvh, the programs without windows, and all libraries that
# these need.
# Requires Debian 12; elsewhere:
#
#   scripts/roots.sh debian12 -- scripts/wheel.sh    # the wheel is in output/ of that clone, see scripts/roots.sh
#   pip install output/embree_cbvh-*.whl             # on the system that uses it

. "$(dirname -- "$0")/lib.sh"

[ "$(getconf GNU_LIBC_VERSION)" = "glibc 2.36" ] || usage_error "a wheel must be built on Debian 12"
libraries=build/wheel-libraries
targets="embree_cbvh embree_cbvh_cp313 embree_cbvh_cp314 cbvh_render cbvh_pathtracer cbvh_terrain"

phase "packages" install_packages "end of the list"
phase "headers and libraries" scripts/packaging/wheel_libraries.sh "$libraries" "$jobs"
phase "configure, get upstream" configure wheel
# shellcheck disable=SC2086
phase "build" build wheel $targets
phase "wheel" /usr/bin/python3 -B scripts/packaging/wheel.py build/wheel "$libraries" output
phase "check" /usr/bin/python3 -B scripts/packaging/wheel_check.py output/embree_cbvh-*.whl
