# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Debian packages that replace Debian's own, for scripts/package.sh:
#
#   libembree3-cbvh      replaces libembree3-3     component lib
#   libembree-cbvh-dev   replaces libembree-dev    component devel
#   embree-cbvh-tools    replaces embree-tools     component examples, with CBVH_EMBREE_TOOLS
#   python3-embree-cbvh  replaces no package       component python, if the module is built
#
# The names differ from Debian's so that updates do not replace our packages. Each package provides the replaced
# package in Embree's version, so that packages that depend on it stay installed, and conflicts with it.

include("${CMAKE_SOURCE_DIR}/kernels/upstream/pin.cmake")

set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL lib devel examples capi capi_devel)
if(TARGET embree_cbvh)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_NAME embree-cbvh)
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_PACKAGE_VENDOR "The Embree CBVH authors")
set(CBVH_PACKAGE_MAINTAINER "The Embree CBVH authors" CACHE STRING
  "Maintainer of the Debian packages: a name, and a mail address in <>.")
set(CPACK_PACKAGE_CONTACT "${CBVH_PACKAGE_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX "${CMAKE_INSTALL_PREFIX}")
set(CPACK_PACKAGE_DIRECTORY "${CMAKE_BINARY_DIR}/packages")
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

# The last line of Debian's changelog: maintainer, mail address, and date of the release.
set(signature "${CBVH_PACKAGE_MAINTAINER}")
if(NOT signature MATCHES ">$")
  string(APPEND signature " <>")
endif()
file(STRINGS "${CMAKE_SOURCE_DIR}/CITATION.cff" released REGEX "^date-released: ")
string(REGEX REPLACE "^date-released: " "" released "${released}")
execute_process(COMMAND "${CMAKE_COMMAND}" -E env LC_ALL=C date -u -R -d "${released}"
  OUTPUT_VARIABLE released OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
set(CPACK_CBVH_SIGNATURE "${signature}  ${released}")
set(CPACK_PRE_BUILD_SCRIPTS "${CMAKE_CURRENT_LIST_DIR}/staging.cmake")
set(CPACK_POST_BUILD_SCRIPTS "${CMAKE_CURRENT_LIST_DIR}/installed_size.cmake")

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# The packages depend on each other's libraries, not on those installed on this machine.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${CMAKE_BINARY_DIR}/embree" "${CMAKE_BINARY_DIR}/kernels/vulkan")
set(CPACK_CBVH_STRIP "${CMAKE_STRIP}")

# In a cross build, dpkg-shlibdeps finds libraries and their packages in the root file system of the target, which has
# the files DEBIAN/shlibs and DEBIAN/symbols as the root of a package that is being built.
if(CMAKE_CROSSCOMPILING)
  if(NOT EXISTS "${CMAKE_SYSROOT}/DEBIAN/shlibs")
    message(FATAL_ERROR "  CMAKE_SYSROOT=${CMAKE_SYSROOT} has no file DEBIAN/shlibs, which packages require: make it "
      "with scripts/arm64_root.sh")
  endif()
  execute_process(COMMAND dpkg-architecture --force --host-type "${CMAKE_LIBRARY_ARCHITECTURE}" --query DEB_HOST_ARCH
    OUTPUT_VARIABLE CPACK_DEBIAN_PACKAGE_ARCHITECTURE OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  list(APPEND CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS
    "${CMAKE_SYSROOT}/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}")
endif()

set(about "Embree CBVH is Embree ${EMBREE_UPSTREAM_VERSION} whose subdivision surfaces with displacement
 can stay compressed in memory and are ray traced from there.")

# cbvh_package(COMPONENT NAME REPLACED MULTIARCH SECTION SUMMARY)
#   REPLACED: a package of Debian, or "". MULTIARCH: the value of the field Multi-Arch.
macro(cbvh_package component name replaced multiarch section summary)
  string(TOUPPER ${component} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${name})
  # CMake 3.31 introduces a variable for this field; before, a line break in another field has the same effect.
  set(CPACK_DEBIAN_${key}_PACKAGE_SECTION "${section}\nMulti-Arch: ${multiarch}")
  if(NOT "${replaced}" STREQUAL "")
    set(CPACK_DEBIAN_${key}_PACKAGE_PROVIDES "${replaced} (= ${EMBREE_UPSTREAM_VERSION})")
    set(CPACK_DEBIAN_${key}_PACKAGE_CONFLICTS ${replaced})
    set(CPACK_DEBIAN_${key}_PACKAGE_REPLACES ${replaced})
  endif()
  set(CPACK_COMPONENT_${key}_DESCRIPTION "${summary}\n${about}")
  install(FILES "${CMAKE_SOURCE_DIR}/scripts/packaging/copyright" "${CMAKE_BINARY_DIR}/sources.sha256"
    DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/${name}" COMPONENT ${component})
endmacro()

cbvh_package(lib libembree3-cbvh libembree3-3 same libs "Ray tracing kernels with compressed subdivision surfaces")
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_LIB_PACKAGE_RECOMMENDS libvulkan1)

cbvh_package(devel libembree-cbvh-dev libembree-dev same libdevel
  "Embree CBVH: headers, manual pages, CMake and pkg-config")
set(CPACK_DEBIAN_DEVEL_PACKAGE_DEPENDS "libembree3-cbvh (= ${PROJECT_VERSION}), libtbb-dev")
set(CPACK_DEBIAN_DEVEL_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEVEL_PACKAGE_SUGGESTS "libvulkan-dev, glslc") # rtcore_vulkan.h, cbvh.glsl

# next to any Embree; these packages replace none
cbvh_package(capi libembree-cbvh1 "" same libs "Compressed subdivision surfaces next to any Embree")
cbvh_package(capi_devel libembree-cbvh1-dev "" same libdevel
  "Compressed subdivision surfaces next to any Embree: development files")
set(CPACK_DEBIAN_CAPI_DEVEL_PACKAGE_DEPENDS "libembree-cbvh1 (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_CAPI_DEVEL_PACKAGE_SHLIBDEPS OFF)
# Packages of versions before 1.0, which contain files of the same names.
foreach(field CONFLICTS REPLACES)
  set(CPACK_DEBIAN_CAPI_PACKAGE_${field} libembree-cbvh0)
  set(CPACK_DEBIAN_CAPI_DEVEL_PACKAGE_${field} libembree-cbvh0-dev)
endforeach()

cbvh_package(examples embree-cbvh-tools embree-tools foreign graphics "Embree CBVH: its programs and Embree's")

if(TARGET embree_cbvh)
  cbvh_package(python python3-embree-cbvh "" same python "Embree CBVH: Python module for NumPy arrays")
  # built for a single version of Python
  get_property(python TARGET embree_cbvh PROPERTY CBVH_PYTHON_VERSION)
  string(REGEX MATCH "^3\\.([0-9]+)" python "${python}")
  math(EXPR next "${CMAKE_MATCH_1} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.${CMAKE_MATCH_1}), python3 (<< 3.${next}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS python3-matplotlib) # for its example
endif()

include(CPack)
