# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Installs our files besides libraries, headers and programs: manual pages and pkg-config files. Adds our version and
# the target embree_vulkan to Embree's CMake package. Components are upstream's: lib, devel, examples.

include(GNUInstallDirs)
get_target_property(CBVH_EMBREE_VERSION embree VERSION)

# --- CMake package: kernels/upstream/patches/package-version.patch writes our part of it ----------

if(TARGET embree_vulkan)
  get_directory_property(folder DIRECTORY "${CMAKE_BINARY_DIR}/upstream" DEFINITION EMBREE_CMAKEEXPORT_DIR)
  install(EXPORT embree_vulkan-targets DESTINATION "${folder}" COMPONENT devel)
endif()

# --- pkg-config ---------------------------------------------------------------------------------

file(RELATIVE_PATH CBVH_PREFIX_FROM_PKGCONFIG "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
string(REGEX REPLACE "/$" "" CBVH_PREFIX_FROM_PKGCONFIG "${CBVH_PREFIX_FROM_PKGCONFIG}")
set(files embree3.pc)
if(TARGET embree_vulkan)
  list(APPEND files embree3-vulkan.pc)
endif()
foreach(file IN LISTS files)
  configure_file("${CMAKE_CURRENT_LIST_DIR}/${file}.in" "${CMAKE_BINARY_DIR}/pkgconfig/${file}" @ONLY)
  install(FILES "${CMAKE_BINARY_DIR}/pkgconfig/${file}" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT devel)
endforeach()
configure_file("${CMAKE_CURRENT_LIST_DIR}/embree_cbvh.pc.in" "${CMAKE_BINARY_DIR}/pkgconfig/embree_cbvh.pc" @ONLY)
install(FILES "${CMAKE_BINARY_DIR}/pkgconfig/embree_cbvh.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig"
  COMPONENT capi_devel)

# --- manual pages, next to upstream's --------------------------------------------------------

find_package(Python3 QUIET COMPONENTS Interpreter)
if(Python3_Interpreter_FOUND)
  set(headers rtcore_compression.h rtcore_surface.h)
  list(TRANSFORM headers PREPEND "${CMAKE_SOURCE_DIR}/include/embree3/")
  if(TARGET embree_vulkan)
    list(APPEND headers "${CMAKE_SOURCE_DIR}/include/embree3/rtcore_vulkan.h")
  endif()
  list(APPEND headers "${CMAKE_SOURCE_DIR}/include/cbvh/cbvh.h")
  set(man "${CMAKE_BINARY_DIR}/man/man3")
  set(script "${CMAKE_CURRENT_LIST_DIR}/man_pages.py")
  add_custom_command(OUTPUT "${man}/rtcSetGeometryCompression.3embree3"
    COMMAND "${CMAKE_COMMAND}" -E rm -rf "${man}"
    COMMAND "${Python3_EXECUTABLE}" -B "${script}" "${PROJECT_VERSION}" "${man}" ${headers}
    DEPENDS "${script}" ${headers} VERBATIM)
  add_custom_target(cbvh_man_pages ALL DEPENDS "${man}/rtcSetGeometryCompression.3embree3")
  install(DIRECTORY "${man}" DESTINATION "${CMAKE_INSTALL_MANDIR}" COMPONENT devel FILES_MATCHING PATTERN "*.3embree3")
  install(DIRECTORY "${man}" DESTINATION "${CMAKE_INSTALL_MANDIR}" COMPONENT capi_devel
    FILES_MATCHING PATTERN "*.3cbvh")
endif()

# The pages of programs show their --help.
set(programs cbvh_render cbvh_viewer cbvh_bench cbvh_pathtracer)
if(NOT CBVH_PACKAGES)
  list(APPEND programs cbvh_terrain) # no package contains it
endif()
find_program(HELP2MAN help2man)
mark_as_advanced(HELP2MAN)
if(HELP2MAN AND NOT CBVH_SANITIZE)
  set(about_cbvh_render "pictures of displaced subdivision surfaces, and the cost of representations")
  set(about_cbvh_viewer "displaced subdivision surfaces in a window")
  set(about_cbvh_bench "speed, memory and errors of representations of displaced subdivision surfaces")
  set(about_cbvh_pathtracer "path tracing of displaced subdivision surfaces on a GPU or a processor")
  set(about_cbvh_terrain "sky-view factors of elevation rasters")
  foreach(program ${programs})
    if(TARGET ${program})
      set(page "${CMAKE_BINARY_DIR}/man/man1/${program}.1")
      string(JOIN " " command ${CMAKE_CROSSCOMPILING_EMULATOR} "$<TARGET_FILE:${program}>")
      add_custom_command(OUTPUT "${page}"
        COMMAND "${HELP2MAN}" --no-info --section=1 "--name=${about_${program}}" "--version-string=${PROJECT_VERSION}"
          "--output=${page}" "${command}"
        DEPENDS ${program} VERBATIM)
      list(APPEND pages "${page}")
    endif()
  endforeach()
  file(MAKE_DIRECTORY "${CMAKE_BINARY_DIR}/man/man1")
  add_custom_target(cbvh_program_pages ALL DEPENDS ${pages})
  if(CBVH_EMBREE_TOOLS AND CBVH_PACKAGES)
    list(APPEND pages "${CMAKE_CURRENT_LIST_DIR}/embree_tutorials.1") # staging.cmake links the programs' names to it
  endif()
  install(FILES ${pages} DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" COMPONENT examples)
endif()

# --- completion of options in bash, from --help ---------------------------------------------------

if(Python3_Interpreter_FOUND AND NOT CBVH_SANITIZE)
  set(script "${CMAKE_CURRENT_LIST_DIR}/completions.py")
  foreach(program ${programs})
    if(TARGET ${program})
      set(completion "${CMAKE_BINARY_DIR}/completions/bash/${program}")
      add_custom_command(OUTPUT "${completion}"
        COMMAND "${Python3_EXECUTABLE}" -B "${script}" "${completion}" ${CMAKE_CROSSCOMPILING_EMULATOR}
          "$<TARGET_FILE:${program}>"
        DEPENDS "${script}" ${program} VERBATIM)
      list(APPEND completions "${completion}")
    endif()
  endforeach()
  add_custom_target(cbvh_completions ALL DEPENDS ${completions})
  install(FILES ${completions} DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" COMPONENT examples)
endif()

# --- documentation pages, and C and C++ examples next to those in Python ------------------------

install(DIRECTORY "${CMAKE_SOURCE_DIR}/docs" DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/doc/embree-cbvh" COMPONENT devel)
install(FILES "${CMAKE_SOURCE_DIR}/kernels/cbvh/paper/README.md" # other pages refer to it
  DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/doc/embree-cbvh/kernels/cbvh/paper" COMPONENT devel)
set(examples_folder "${CMAKE_INSTALL_DATAROOTDIR}/doc/embree-cbvh/examples")
install(DIRECTORY "${CMAKE_SOURCE_DIR}/tutorials/codec" DESTINATION "${examples_folder}"
  COMPONENT devel FILES_MATCHING PATTERN "*.cpp")
install(DIRECTORY "${CMAKE_SOURCE_DIR}/tutorials/capi/" DESTINATION "${examples_folder}"
  COMPONENT capi_devel FILES_MATCHING PATTERN "*.c" PATTERN "*.cpp" PATTERN "*.h")
install(FILES "${CMAKE_SOURCE_DIR}/CHANGELOG.md" DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT lib)
