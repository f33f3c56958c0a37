# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Writes the current commit into a header; runs at every build.
#   cmake -DSOURCE=... -DOUTPUT=... -P build_info.cmake

cmake_policy(VERSION 3.21)

set(commit "unknown")
execute_process(COMMAND git -C "${SOURCE}" rev-parse --short=12 HEAD
  OUTPUT_VARIABLE head OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(NOT failed)
  set(commit "${head}")
  execute_process(
    COMMAND git -C "${SOURCE}" status --porcelain --untracked-files=no -- kernels include common tutorials/bench
    OUTPUT_VARIABLE changes ERROR_QUIET)
  if(changes)
    string(APPEND commit "+changes")
  endif()
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#pragma once\n#define CBVH_BUILD_COMMIT \"@commit@\"\n" @ONLY)
