# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Files that are compiled for the lowest ISA. cbvh_files() compiles some of them for further ISAs, too.
list(APPEND EMBREE_LIBRARY_FILES
  cbvh/api/settings.cpp
  cbvh/api/factory.cpp
  cbvh/api/geometry_commit.cpp
  cbvh/api/interpolation_checks.cpp
  cbvh/api/rtcore_compression.cpp
  cbvh/operations/closest_point.cpp
  cbvh/operations/compression.cpp
  cbvh/operations/device.cpp
  cbvh/operations/device_string.cpp
  cbvh/operations/dicing.cpp
  cbvh/operations/errors.cpp
  cbvh/operations/files.cpp
  cbvh/operations/stored_surface.cpp
  cbvh/operations/struct_size.cpp
  cvert/portable/reason.cpp
  cvert/file/checksum.cpp
  cvert/file/directory.cpp
  cvert/file/file.cpp
  cvert/file/record.cpp
  cvert/file/writer.cpp
  cbvh/files/saved_surface.cpp
  cbvh/building/input_bytes.cpp
  cbvh/files/mapped_blocks.cpp
  cbvh/files/loaded_geometry.cpp
  cbvh/files/loaded_surface.cpp
  cbvh/backend/flat_scene.cpp
  cbvh/building/builder.cpp
  cbvh/blocks/stored_triangles.cpp
  cbvh/blocks/stored_clusters.cpp
  cbvh/blocks/surface_blocks.cpp
  cbvh/blocks/surface_conversion.cpp
  cbvh/surface/input_checks.cpp
  cbvh/surface/mesh_regions.cpp
  cbvh/surface/quad_regions.cpp
  cbvh/surface/triangle_pairs.cpp
  cbvh/surface/welded_vertices.cpp
  cbvh/exact/tables.cpp
  cbvh/traversal/thread_cache.cpp
  cbvh/traversal/intersector1.cpp
  cbvh/traversal/intersectorK.cpp
  cbvh/traversal/mesh_intersector1.cpp
  cbvh/traversal/moving_intersector1.cpp
  cbvh/traversal/point_query.cpp)

if(NOT EMBREE_CBVH_NO_PAPER)
  list(APPEND EMBREE_LIBRARY_FILES cbvh/paper/node_tables.cpp cbvh/paper/rays.cpp)
endif()

# Appends the files that are compiled per ISA to the list named by `target`.
macro(cbvh_files target isa)
  list(APPEND ${target} cbvh/traversal/intersector1.cpp cbvh/traversal/intersectorK.cpp cbvh/traversal/point_query.cpp
    cbvh/traversal/mesh_intersector1.cpp cbvh/traversal/moving_intersector1.cpp)
  if(NOT EMBREE_CBVH_NO_PAPER)
    list(APPEND ${target} cbvh/paper/rays.cpp)
  endif()
  # Upstream also selects its subdivision builder from the lowest ISA and AVX.
  if(${isa} EQUAL ${AVX})
    list(APPEND ${target} cbvh/building/builder.cpp)
  endif()
  # For the lowest ISA, the library already compiles them.
  if(${isa} EQUAL ${ISA_LOWEST})
    list(REMOVE_ITEM ${target} ${EMBREE_LIBRARY_FILES})
  endif()
endmacro()
