# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# CPack runs this script on the finished packages. It corrects the field Installed-Size: CPack counts the file that a
# symbolic link refers to once per link. As dpkg-gencontrol does, counts the files in units of 1024 bytes, and 1 for
# each folder and link.

foreach(package IN LISTS CPACK_PACKAGE_FILES)
  set(folder "${package}.control")
  file(MAKE_DIRECTORY "${folder}")
  execute_process(COMMAND dpkg-deb --contents "${package}"
    COMMAND awk "{ size += /^-/ ? int(($3 + 1023)/1024) : 1 } END { print size }"
    OUTPUT_VARIABLE size OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND dpkg-deb --control "${package}" "${folder}" COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND sed -i "s/^Installed-Size: .*/Installed-Size: ${size}/" "${folder}/control"
    COMMAND_ERROR_IS_FATAL ANY)
  # The member's name depends on the compression.
  execute_process(COMMAND ar t "${package}" OUTPUT_VARIABLE members COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCH "control[a-z.]+" member "${members}")
  execute_process(COMMAND tar --create --auto-compress --file "${package}.${member}" --format=gnu --owner=0 --group=0
      --numeric-owner --sort=name --directory "${folder}" .
    COMMAND_ERROR_IS_FATAL ANY)
  file(RENAME "${package}.${member}" "${folder}/${member}")
  execute_process(COMMAND ar r "${package}" "${member}" WORKING_DIRECTORY "${folder}" COMMAND_ERROR_IS_FATAL ANY)
  file(REMOVE_RECURSE "${folder}")
endforeach()
