# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Files of the library, compiled once for the lowest ISA.
list(APPEND EMBREE_LIBRARY_FILES
  cbvh/api/settings.cpp
  cbvh/api/device_string.cpp
  cbvh/api/factory.cpp
  cbvh/api/geometry_commit.cpp
  cbvh/api/rtcore_compression.cpp
  cbvh/api/rtcore_compressed_triangles.cpp
  cbvh/api/rtcore_compressed_clusters.cpp
  cbvh/api/rtcore_dicing.cpp
  cbvh/api/rtcore_compressed_files.cpp
  cbvh/api/loaded_geometry.cpp
  cbvh/scene/file_checksum.cpp
  cbvh/scene/file_writer.cpp
  cbvh/scene/input_bytes.cpp
  cbvh/scene/mapped_blocks.cpp
  cbvh/scene/mapped_file.cpp
  cbvh/scene/flat_scene.cpp
  cbvh/scene/builder.cpp
  cbvh/scene/stored_triangles.cpp
  cbvh/scene/stored_clusters.cpp
  cbvh/scene/surface_blocks.cpp
  cbvh/surface/quad_regions.cpp
  cbvh/framed/node_tables.cpp
  cbvh/vert/tables.cpp
  cbvh/scene/thread_cache.cpp
  cbvh/scene/intersector1.cpp
  cbvh/scene/intersectorK.cpp)

# Files of one ISA, appended to the list that `target` names.
macro(cbvh_files target isa)
  list(APPEND ${target} cbvh/scene/intersector1.cpp cbvh/scene/intersectorK.cpp)
  # As upstream's subdivision builder, which is chosen among the lowest ISA and AVX.
  if(${isa} EQUAL ${AVX})
    list(APPEND ${target} cbvh/scene/builder.cpp)
  endif()
  # The library compiles the files of the lowest ISA already: not twice.
  if(${isa} EQUAL ${ISA_LOWEST})
    list(REMOVE_ITEM ${target} ${EMBREE_LIBRARY_FILES})
  endif()
endmacro()
