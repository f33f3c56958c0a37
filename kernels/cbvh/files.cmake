# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Files of the library, compiled once for the lowest ISA.
list(APPEND EMBREE_LIBRARY_FILES
  cbvh/settings.cpp
  cbvh/factory.cpp
  cbvh/node_tables.cpp
  cbvh/rtcore_compression.cpp
  cbvh/builder.cpp
  cbvh/intersector1.cpp)

# Files of one ISA, appended to the list that `target` names.
macro(cbvh_files target isa)
  list(APPEND ${target} cbvh/intersector1.cpp)
  # As upstream's subdivision builder, which is chosen among the lowest ISA and AVX.
  if(${isa} EQUAL ${AVX})
    list(APPEND ${target} cbvh/builder.cpp)
  endif()
  # The library compiles the files of the lowest ISA already: not twice.
  if(${isa} EQUAL ${ISA_LOWEST})
    list(REMOVE_ITEM ${target} ${EMBREE_LIBRARY_FILES})
  endif()
endmacro()
