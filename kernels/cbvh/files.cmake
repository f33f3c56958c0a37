# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Files of the library, compiled once for the lowest ISA.
list(APPEND EMBREE_LIBRARY_FILES
  cbvh/api/settings.cpp
  cbvh/api/factory.cpp
  cbvh/api/rtcore_compression.cpp
  cbvh/flat/flat_scene.cpp
  cbvh/build/builder.cpp
  cbvh/trace/node_tables.cpp
  cbvh/trace/vert_tables.cpp
  cbvh/trace/thread_cache.cpp
  cbvh/trace/intersector1.cpp
  cbvh/trace/intersectorK.cpp)

# Files of one ISA, appended to the list that `target` names.
macro(cbvh_files target isa)
  list(APPEND ${target} cbvh/trace/intersector1.cpp cbvh/trace/intersectorK.cpp)
  # As upstream's subdivision builder, which is chosen among the lowest ISA and AVX.
  if(${isa} EQUAL ${AVX})
    list(APPEND ${target} cbvh/build/builder.cpp)
  endif()
  # The library compiles the files of the lowest ISA already: not twice.
  if(${isa} EQUAL ${ISA_LOWEST})
    list(REMOVE_ITEM ${target} ${EMBREE_LIBRARY_FILES})
  endif()
endmacro()
