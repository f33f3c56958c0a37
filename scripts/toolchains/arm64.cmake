# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Toolchain of the preset `arm64`: Debian's cross compiler, and the libraries of
# CBVH_ARM64_ROOT, a folder that scripts/arm64_root.sh makes. Programs and tests
# run under qemu-aarch64-static.

set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)

set(CBVH_ARM64_ROOT "$ENV{CBVH_ARM64_ROOT}" CACHE PATH "Libraries and headers of Debian for arm64.")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES CBVH_ARM64_ROOT)
if(NOT EXISTS "${CBVH_ARM64_ROOT}/usr/lib/aarch64-linux-gnu")
  message(FATAL_ERROR "  CBVH_ARM64_ROOT=${CBVH_ARM64_ROOT}: expected a folder made by scripts/arm64_root.sh")
endif()
set(CMAKE_SYSROOT "${CBVH_ARM64_ROOT}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind LIBRARY INCLUDE PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -L "${CBVH_ARM64_ROOT}")
