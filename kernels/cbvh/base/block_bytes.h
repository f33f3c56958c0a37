// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How the bytes of blocks and tiles are divided in statistics (CompressionStatistics::headerBytes to leafBytes). */

#include "../../cvert/format/mesh_tile.h"
#include "codec_names.h"
#include <cstddef>

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! Bytes of memory that are reserved per tile: most have 3 or 4 bytes per vertex. */
static const size_t expectedTileBytes = 1408;

struct BlockBytes {
  size_t header, nodes, leaves;

  /*! block: a cVERT block or a tile. size: in bytes, without padding. */
  BlockBytes(const VertHeader* block, size_t size) {
    if (isTile(block->info)) {
      const VertHeader* const first = tileOfStep(block, 0);
      const size_t begin = size_t((const uint8_t*)first - (const uint8_t*)block);
      set(begin + tileBoxesOffset(first->info), begin + tileVerticesOffset(first->region, first->info), size);
    } else {
      const VertLayout layout = vertLayout(block->region, block->info);
      set(layout.margins, isRaw(block->info) ? layout.margins : layout.cell, size);
    }
  }

  /*! The same for a mesh block at its first time step, and for a mesh tile. */
  BlockBytes(const MeshHeader* block, size_t size) {
    const MeshLayout layout = meshLayout(block->counts);
    set(layout.boxes, layout.topology, size);
  }
  BlockBytes(const MeshTileHeader* tile, size_t size) {
    const uint32_t groups = meshGroups(tile->counts);
    const size_t begin = size_t((const uint8_t*)meshTileOfStep(tile, 0) - (const uint8_t*)tile);
    set(begin + meshTilePlanes(groups, 0), begin + meshTileGroups(groups), size);
  }

  /*! sums: CompressionStatistics. */
  template<typename Sums> void addTo(Sums& sums) const {
    sums.headerBytes += header;
    sums.nodeBytes += nodes;
    sums.leafBytes += leaves;
  }
  template<typename Sums> void removeFrom(Sums& sums) const {
    sums.headerBytes -= header;
    sums.nodeBytes -= nodes;
    sums.leafBytes -= leaves;
  }

private:
  void set(size_t headerEnd, size_t nodesEnd, size_t size) {
    header = headerEnd;
    nodes = nodesEnd - headerEnd;
    leaves = ((size + blockAlignment - 1) & ~size_t(blockAlignment - 1)) - nodesEnd;
  }
};
}} // namespace embree::cbvh::CBVH_ISA
