# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Changes a build for a Python wheel, see scripts/wheel.sh.
#
# A wheel has one library of kernels, libembree_cbvh. The module, the programs and libembree3_vulkan also use Embree's
# API in it. A Python process may contain another Embree, whose functions have the same names: the dynamic linker would
# take the first one that it finds. So libembree_cbvh exports Embree's functions under other names, with __wrap_ in
# front, and the linker's option --wrap makes callers use these.

# cbvh_private_names(LIBRARY INTERFACE HEADER...): exports the functions that headers declare with RTC_API from LIBRARY
# under private names. Targets that link INTERFACE call them by these.
function(cbvh_private_names library interface)
  set(exported "")
  set(called "")
  foreach(header IN LISTS ARGN)
    file(STRINGS "${header}" declarations REGEX "^RTC_API ")
    foreach(declaration IN LISTS declarations)
      if(NOT declaration MATCHES "[ *](rtc[A-Za-z0-9]+) *\\(")
        message(FATAL_ERROR "  ${header}: no name of a function in `${declaration}`")
      endif()
      string(APPEND exported "--defsym=__wrap_${CMAKE_MATCH_1}=${CMAKE_MATCH_1}\n")
      string(APPEND called "--wrap=${CMAKE_MATCH_1}\n")
    endforeach()
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${header}")
  endforeach()
  set(names "${CMAKE_BINARY_DIR}/private_names/${library}")
  file(CONFIGURE OUTPUT "${names}.exported" CONTENT "${exported}" @ONLY)
  file(CONFIGURE OUTPUT "${names}.called" CONTENT "${called}" @ONLY)
  target_link_options(${library} PRIVATE "-Wl,@${names}.exported")
  target_link_options(${interface} INTERFACE "-Wl,@${names}.called")
endfunction()

# --- libembree_cbvh with Embree's API ------------------------------------------------------

add_library(cbvh_wheel_kernels INTERFACE)
target_link_libraries(cbvh_wheel_kernels INTERFACE cbvh_capi)
target_include_directories(cbvh_wheel_kernels INTERFACE "${CMAKE_BINARY_DIR}/upstream/include")
# The libraries of the wheel are linked statically where possible, and export nothing.
target_link_options(cbvh_wheel_kernels INTERFACE -Wl,--as-needed -Wl,--gc-sections -Wl,--exclude-libs,ALL)

file(GLOB headers "${CMAKE_BINARY_DIR}/upstream/include/embree3/rtcore*.h")
list(FILTER headers EXCLUDE REGEX "/rtcore_vulkan\\.h$")
cbvh_private_names(cbvh_capi cbvh_wheel_kernels ${headers} "${CMAKE_SOURCE_DIR}/kernels/cbvh/backend/flat_scene.h")
set(exports "${CMAKE_BINARY_DIR}/private_names/exports")
file(CONFIGURE OUTPUT "${exports}.map" CONTENT "CBVH_WHEEL { global: __wrap_rtc*; };\n")
target_link_options(cbvh_capi PRIVATE "-Wl,--version-script=${exports}.map")
if(NOT TARGET embree_vulkan)
  message(FATAL_ERROR "  a wheel contains libembree3_vulkan, which needs Vulkan's headers, glslc and Python")
endif()
cbvh_private_names(embree_vulkan embree_vulkan "${CMAKE_SOURCE_DIR}/include/embree3/rtcore_vulkan.h")
file(CONFIGURE OUTPUT "${exports}_vulkan.map" CONTENT "CBVH_WHEEL { global: __wrap_rtc*; local: *; };\n")
target_link_options(embree_vulkan PRIVATE "-Wl,--version-script=${exports}_vulkan.map")

# --- libraries that scripts/packaging/wheel_libraries.sh built: common/ finds them --------------

# OpenImageIO's CMake package silently leaves out libraries whose targets do not exist.
find_package(Threads REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(Boost REQUIRED COMPONENTS thread)
find_package(OpenImageIO REQUIRED CONFIG)
set(OpenImageIO_HEADERS "${OpenImageIO_INCLUDE_DIR}")
set(OpenImageIO_FILE OpenImageIO::OpenImageIO)
set(OpenImageIO_Util_FILE OpenImageIO::OpenImageIO_Util)
