# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# CPack runs this script on the installed files of all packages before it packs them. It does what debhelper does for
# Debian's own packages: compresses manual pages, removes sections that nothing reads, and adds Debian's changelog and
# the overrides of lintian. It also prepares for dpkg-shlibdeps, which CPack runs next.

# run COMMAND...
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# In a cross build, dpkg-shlibdeps must use the target's objdump.
if(CPACK_DEBIAN_PACKAGE_ARCHITECTURE)
  set(ENV{DEB_HOST_ARCH} "${CPACK_DEBIAN_PACKAGE_ARCHITECTURE}")
endif()

# Folders of components contain the files of one package each.
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  set(folder "${CPACK_TEMPORARY_DIRECTORY}/${component}")
  if(NOT IS_DIRECTORY "${folder}/usr")
    message(FATAL_ERROR "There are no files of ${component} in ${folder}.")
  endif()
  string(TOUPPER ${component} key)
  set(package "${CPACK_DEBIAN_${key}_PACKAGE_NAME}")

  # --- manual pages ---------------------------------------------------------------------------------

  file(GLOB pages "${folder}/usr/share/man/man*/*")
  foreach(page IN LISTS pages)
    # Programs that index pages require the section NAME as .SH, in plain text. Upstream's pages have .SS and markup,
    # and state section 3 instead of 3embree3.
    if(page MATCHES "\\.3embree3$")
      run(sed -i -e [[s/^\(\.TH "[^"]*"\) "3"/\1 "3embree3"/]] -e [[s/^\.SS /.SH /]]
        -e [[/^\.SH NAME$/,/^\.SH [^N]/{]] -e [[/^\.IP$/d]] -e [[/^\.nf$/d]] -e [[/^\.fi$/d]] -e [[/^\\f\[[CR]\]$/d]]
        -e "}" "${page}")
    endif()
    run(gzip -9 -n "${page}")
  endforeach()

  # Embree's programs share a page.
  set(programs "")
  if(EXISTS "${folder}/usr/share/man/man1/embree_tutorials.1.gz")
    file(GLOB programs RELATIVE "${folder}/usr/bin" "${folder}/usr/bin/*")
  endif()
  foreach(program IN LISTS programs)
    if(NOT EXISTS "${folder}/usr/share/man/man1/${program}.1.gz")
      file(CREATE_LINK embree_tutorials.1.gz "${folder}/usr/share/man/man1/${program}.1.gz" SYMBOLIC)
    endif()
  endforeach()

  # --- binaries -------------------------------------------------------------------------------------

  file(GLOB_RECURSE files LIST_DIRECTORIES false
    "${folder}/usr/bin/*" "${folder}/usr/lib/*.so" "${folder}/usr/lib/*.so.*" "${folder}/usr/lib/*.a")
  foreach(file IN LISTS files)
    if(NOT IS_SYMLINK "${file}")
      run("${CPACK_CBVH_STRIP}" --remove-section=.comment --remove-section=.note "${file}")
    endif()
  endforeach()

  # The package of our libraries, for dpkg-shlibdeps. Without it, programs depend on Debian's libembree3-3 if that is
  # installed. CPack removes the file.
  if(component MATCHES "^(examples|python)$")
    foreach(library libembree3 libembree3_vulkan)
      file(APPEND "${folder}/debian/shlibs.local"
        "${library} 3 ${CPACK_DEBIAN_LIB_PACKAGE_NAME} (= ${CPACK_PACKAGE_VERSION})\n")
    endforeach()
  endif()

  # --- documents ------------------------------------------------------------------------------------

  # The file `copyright` contains the license.
  file(REMOVE "${folder}/usr/share/doc/embree3/LICENSE.txt")

  set(changelog "${folder}/usr/share/doc/${package}/changelog")
  file(WRITE "${changelog}" "${CPACK_PACKAGE_NAME} (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium\n\n"
    "  * The file CHANGELOG.md of the sources lists the changes.\n\n -- ${CPACK_CBVH_SIGNATURE}\n")
  run(gzip -9 -n "${changelog}")

  # Lines of lintian-overrides that begin with the package's name. Overrides of files that do not exist are findings.
  file(STRINGS "${CMAKE_CURRENT_LIST_DIR}/lintian-overrides" overrides REGEX "^${package}: ")
  file(GLOB interposer "${folder}/usr/lib/*/libembree_cbvh_interposer.so")
  if(NOT interposer)
    list(FILTER overrides EXCLUDE REGEX "interposer")
  endif()
  if(overrides)
    list(JOIN overrides "\n" overrides)
    file(WRITE "${folder}/usr/share/lintian/overrides/${package}" "${overrides}\n")
  endif()
endforeach()
