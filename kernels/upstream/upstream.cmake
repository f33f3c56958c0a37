# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Creates a patched tree of upstream's source in the build directory:
#
#   archive (registry, or EMBREE_UPSTREAM_ARCHIVE) -- checked against pin.cmake
#      |                      or EMBREE_UPSTREAM_SOURCE_DIR, an unpacked tree
#      v  unpack, apply patches/series           (in a temporary directory)
#   <build>/upstream                              (one rename at the end)
#      ^  our sources, linked in file by file
#
# A failure prints one FATAL_ERROR line and does not change the tree.

include_guard(GLOBAL)
include("${CMAKE_CURRENT_LIST_DIR}/pin.cmake")
set(UPSTREAM_DIR "${CMAKE_CURRENT_LIST_DIR}")

set(EMBREE_UPSTREAM_ARCHIVE "" CACHE FILEPATH
  "Local copy of upstream's source archive; empty: download it from the machine's package registry.")
set(EMBREE_UPSTREAM_SOURCE_DIR "" CACHE PATH
  "Unpacked, unpatched source of upstream to use instead of an archive; it is copied, not changed.")
set(EMBREE_UPSTREAM_CACHE "${UPSTREAM_DIR}/../../.upstream" CACHE PATH
  "Directory that keeps the downloaded archive, shared by all build directories.")
mark_as_advanced(EMBREE_UPSTREAM_CACHE)

# Two leading blanks prevent CMake from wrapping the message.
function(upstream_fail message)
  message(FATAL_ERROR "  upstream: ${message}")
endfunction()

# Fails unless `archive` has the pinned checksum.
function(upstream_check archive)
  if(NOT EXISTS "${archive}" OR IS_DIRECTORY "${archive}")
    upstream_fail("${archive}: no such file")
  endif()
  file(SHA256 "${archive}" sum)
  if(NOT sum STREQUAL EMBREE_UPSTREAM_SHA256)
    file(SIZE "${archive}" size)
    upstream_fail("${archive}: SHA-256 is ${sum} (${size} bytes), expected ${EMBREE_UPSTREAM_SHA256}")
  endif()
endfunction()

# Sets `result` to the path of a checked archive. Downloads it if necessary.
function(upstream_archive result)
  set(cached "${EMBREE_UPSTREAM_CACHE}/${EMBREE_UPSTREAM_PACKAGE}_${EMBREE_UPSTREAM_VERSION}.orig.tar.xz")
  get_filename_component(cached "${cached}" ABSOLUTE)
  if(EMBREE_UPSTREAM_ARCHIVE)
    get_filename_component(archive "${EMBREE_UPSTREAM_ARCHIVE}" ABSOLUTE BASE_DIR "${CMAKE_SOURCE_DIR}")
    upstream_check("${archive}")
    set(${result} "${archive}" PARENT_SCOPE)
    return()
  endif()

  if(NOT EXISTS "${cached}")
    string(RANDOM LENGTH 8 tag)
    set(temporary "${EMBREE_UPSTREAM_CACHE}/.download-${tag}")
    file(MAKE_DIRECTORY "${temporary}")
    message(STATUS "Downloading source package ${EMBREE_UPSTREAM_PACKAGE} ${EMBREE_UPSTREAM_VERSION}")
    execute_process(
      COMMAND "${UPSTREAM_DIR}/fetch.sh" "${EMBREE_UPSTREAM_PACKAGE}" "${EMBREE_UPSTREAM_VERSION}" "${temporary}"
              "${EMBREE_UPSTREAM_SUITE}"
      RESULT_VARIABLE status OUTPUT_VARIABLE log ERROR_VARIABLE log)
    file(GLOB archive "${temporary}/*.orig.tar.*")
    if(NOT status EQUAL 0 OR NOT archive)
      file(REMOVE_RECURSE "${temporary}")
      if(EXISTS "$ENV{EMBREE_UPSTREAM_FALLBACK}")
        message(STATUS "The registry does not answer, using $ENV{EMBREE_UPSTREAM_FALLBACK}")
        upstream_check("$ENV{EMBREE_UPSTREAM_FALLBACK}")
        set(${result} "$ENV{EMBREE_UPSTREAM_FALLBACK}" PARENT_SCOPE)
        return()
      endif()
      string(REGEX REPLACE "\n+$" "" log "${log}")
      string(REGEX REPLACE "^.*\n" "" log "${log}")
      string(CONCAT message
        "download of source package ${EMBREE_UPSTREAM_PACKAGE} ${EMBREE_UPSTREAM_VERSION} failed (${log}); "
        "copy ${EMBREE_UPSTREAM_PACKAGE}_${EMBREE_UPSTREAM_VERSION}.orig.tar.xz from pool/main/e/embree of any mirror "
        "of Debian, and set the environment variable EMBREE_UPSTREAM_FALLBACK, or the CMake variable "
        "EMBREE_UPSTREAM_ARCHIVE, to its path")
      upstream_fail("${message}")
    endif()
    file(RENAME "${archive}" "${cached}.part")
    file(REMOVE_RECURSE "${temporary}")
    file(SHA256 "${cached}.part" sum)
    if(NOT sum STREQUAL EMBREE_UPSTREAM_SHA256)
      file(REMOVE "${cached}.part")
      upstream_fail("${cached}: downloaded with SHA-256 ${sum}, expected ${EMBREE_UPSTREAM_SHA256}")
    endif()
    file(RENAME "${cached}.part" "${cached}")
  endif()
  upstream_check("${cached}")
  set(${result} "${cached}" PARENT_SCOPE)
endfunction()

# Applies the patches to `tree`. If that fails, removes the folder `cleanup`.
function(upstream_patch tree cleanup patches)
  find_program(PATCH_PROGRAM patch)
  mark_as_advanced(PATCH_PROGRAM)
  foreach(patch IN LISTS patches)
    set(log "no program named patch")
    if(PATCH_PROGRAM)
      # --fuzz=0: changed context needs a review
      execute_process(
        COMMAND "${PATCH_PROGRAM}" --strip=1 --fuzz=0 --forward --batch --no-backup-if-mismatch
                --reject-file=- --input=${UPSTREAM_PATCHES}/${patch}
        WORKING_DIRECTORY "${tree}" RESULT_VARIABLE status OUTPUT_VARIABLE log ERROR_VARIABLE log)
    endif()
    if(NOT PATCH_PROGRAM OR NOT status EQUAL 0)
      file(REMOVE_RECURSE "${cleanup}")
      string(REGEX MATCH "Hunk[^\n]*FAILED[^\n]*|can't find file[^\n]*|No such file[^\n]*" cause "${log}")
      if(NOT cause)
        string(STRIP "${log}" cause)
        string(REPLACE "\n" "; " cause "${cause}")
      endif()
      upstream_fail("${patch} does not fit ${EMBREE_UPSTREAM_PACKAGE} ${EMBREE_UPSTREAM_VERSION}: ${cause}")
    endif()
  endforeach()
endfunction()

# Creates or updates `tree` from the archive and the patch series.
function(upstream_provide tree)
  set(UPSTREAM_PATCHES "${UPSTREAM_DIR}/patches")
  file(STRINGS "${UPSTREAM_PATCHES}/series" patches REGEX "^[^#]")
  set(identity "${EMBREE_UPSTREAM_SHA256} ${EMBREE_UPSTREAM_SOURCE_DIR}")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${UPSTREAM_PATCHES}/series")
  foreach(patch IN LISTS patches)
    if(NOT EXISTS "${UPSTREAM_PATCHES}/${patch}")
      upstream_fail("${UPSTREAM_PATCHES}/${patch}: named in series, no such file")
    endif()
    file(SHA256 "${UPSTREAM_PATCHES}/${patch}" sum)
    string(APPEND identity " ${sum}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${UPSTREAM_PATCHES}/${patch}")
  endforeach()

  # checked even if the tree is up to date
  if(NOT EMBREE_UPSTREAM_SOURCE_DIR AND EMBREE_UPSTREAM_ARCHIVE)
    upstream_archive(archive)
  endif()
  set(stamp "${tree}/.cbvh-stamp")
  if(EXISTS "${stamp}")
    file(READ "${stamp}" applied)
    if(applied STREQUAL identity)
      return()
    endif()
  endif()

  string(RANDOM LENGTH 8 tag)
  set(temporary "${tree}.tmp-${tag}")
  if(EMBREE_UPSTREAM_SOURCE_DIR)
    get_filename_component(source "${EMBREE_UPSTREAM_SOURCE_DIR}" ABSOLUTE BASE_DIR "${CMAKE_SOURCE_DIR}")
    if(NOT EXISTS "${source}/kernels/rtcore_config.h.in")
      upstream_fail("${source}: not a source tree of Embree")
    endif()
    file(COPY "${source}/" DESTINATION "${temporary}/source")
    set(fresh "${temporary}/source")
    set(archive "")
  else()
    upstream_archive(archive)
    file(MAKE_DIRECTORY "${temporary}")
    execute_process(COMMAND "${CMAKE_COMMAND}" -E tar xf "${archive}"
      WORKING_DIRECTORY "${temporary}" RESULT_VARIABLE status OUTPUT_QUIET ERROR_QUIET)
    file(GLOB fresh "${temporary}/*/kernels")
    if(NOT status EQUAL 0 OR NOT fresh)
      file(REMOVE_RECURSE "${temporary}")
      upstream_fail("${archive}: cannot be unpacked")
    endif()
    get_filename_component(fresh "${fresh}" DIRECTORY)
  endif()
  upstream_patch("${fresh}" "${temporary}" "${patches}")

  if(NOT EXISTS "${tree}")
    file(WRITE "${fresh}/.cbvh-stamp" "${identity}")
    file(RENAME "${fresh}" "${tree}")
  else()
    # Copies only files that differ, so that only these are compiled again. The stamp is removed first, so that the next
    # configure completes an interrupted copy.
    message(STATUS "Patch series changed, updating ${tree}")
    file(REMOVE "${stamp}")
    file(GLOB_RECURSE files RELATIVE "${fresh}" "${fresh}/*")
    foreach(file IN LISTS files)
      get_filename_component(directory "${tree}/${file}" DIRECTORY)
      file(MAKE_DIRECTORY "${directory}")
      file(COPY_FILE "${fresh}/${file}" "${tree}/${file}" ONLY_IF_DIFFERENT)
    endforeach()
    file(WRITE "${stamp}" "${identity}")
  endif()
  file(REMOVE_RECURSE "${temporary}")
  set(EMBREE_UPSTREAM_USED_ARCHIVE "${archive}" CACHE INTERNAL "Archive of the tree, for the tests.")
endfunction()

# Links single files of `from` into `to`. Through a link to the folder, `#include "../common/..."` would not find
# upstream's headers.
function(upstream_link from to)
  file(GLOB_RECURSE sources RELATIVE "${from}" CONFIGURE_DEPENDS "${from}/*.h" "${from}/*.cpp" "${from}/*.cmake")
  file(GLOB_RECURSE present RELATIVE "${to}" "${to}/*")
  foreach(file IN LISTS present)
    if(NOT file IN_LIST sources)
      file(REMOVE "${to}/${file}")
    endif()
  endforeach()
  foreach(file IN LISTS sources)
    if(NOT EXISTS "${to}/${file}")
      get_filename_component(directory "${to}/${file}" DIRECTORY)
      file(MAKE_DIRECTORY "${directory}")
      file(REMOVE "${to}/${file}") # a dangling link
      file(CREATE_LINK "${from}/${file}" "${to}/${file}" SYMBOLIC)
    endif()
  endforeach()
endfunction()

# Copies public headers, because upstream installs their folder and would install links as links. Removes copies of
# headers that no longer exist.
function(upstream_headers from to)
  file(GLOB headers RELATIVE "${from}" CONFIGURE_DEPENDS "${from}/*.h")
  foreach(header IN LISTS UPSTREAM_HEADERS)
    if(NOT header IN_LIST headers)
      file(REMOVE "${to}/${header}")
    endif()
  endforeach()
  set(UPSTREAM_HEADERS "${headers}" CACHE INTERNAL "headers that were copied")
  foreach(header IN LISTS headers)
    configure_file("${from}/${header}" "${to}/${header}" COPYONLY)
  endforeach()
endfunction()
