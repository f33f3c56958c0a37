// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How the patches of a geometry are stored, by its settings (settings/settings.h). Grids, meshes and moving geometry
 * are always stored exactly, as cVERT or its tiles. */

#include "../embree/scene.h"
#include "../base/kinds.h"

namespace embree::isa {
/*! Grids with more time steps need more bytes as tiles than in Embree, where steps cost none: about 5 per quad and
 * step, and 17. They are stored as cVERT. */
static const unsigned maxTileStepsOfGrids = 3;

struct CompressionPlan {
  uint32_t surfaceNumber; //!< see base/surface_ids.h
  unsigned numTimeSteps;
  BBox1f timeRange;
  CompressionSettings settings; //!< resolved

  /*! number: surface number. */
  CompressionPlan(const CompressibleGeometry* geometry, uint32_t number)
    : surfaceNumber(number | (geometry->numTimeSteps != 1 ? cbvh::movingSurface : 0)),
      numTimeSteps(geometry->numTimeSteps),
      timeRange(geometry->time_range),
      settings(geometry->compression.resolve(geometry->device->compression)) {
    isCompressed = cbvh::findKind(settings.compression, blockKind);
    areBlocksTiles = isCompressed && blockKind == cbvh::Kind::CTILE &&
                     (geometry->ownType != Geometry::GTY_GRID_MESH || numTimeSteps <= maxTileStepsOfGrids);
    isFormChosen = geometry->device->compression.memory != nullptr;
    if (geometry->ownType != Geometry::GTY_SUBDIV_MESH || moves() || blockKind == cbvh::Kind::CTILE)
      blockKind = cbvh::Kind::CVERT;
  }

  /*! True if a moving cage that requests compression is compressed. It is stored as cVERT, so requests of other
   *  kinds need the setting fallback_faces. */
  static bool compressesMotion(const SubdivMesh* geometry) {
    const CompressionSettings settings = geometry->compression.resolve(geometry->device->compression);
    return cbvh::isExact(settings.compression) || settings.fallbackFaces != 0;
  }

  bool moves() const { return numTimeSteps != 1; }

  bool isLossless() const { return kind() == cbvh::Kind::CVERT && settings.maxError == 0.0f; }

  /*! True if blocks become tiles while they are built. */
  bool makesTiles() const { return areBlocksTiles && !isFormChosen; }

  /*! True if commits of scenes choose between tiles and cVERT blocks, by the device's budget. */
  bool mayBecomeTiles() const { return areBlocksTiles && isFormChosen; }

  /*! Kind of the blocks, CVERT for tiles. Meaningless unless compresses(). */
  cbvh::Kind kind() const { return blockKind; }

  /*! True if patches that cLEAF represents badly are stored as cVERT (the setting fallback_faces). */
  bool hasFallbackFaces() const { return compresses() && kind() == cbvh::Kind::CLEAF && settings.fallbackFaces != 0; }

  /*! True if faces use the border vertices of the owners of edges and corners, see surface/shared_border.h. */
  bool sharesBorders() const { return compresses() && (kind() == cbvh::Kind::CVERT || hasFallbackFaces()); }

  /*! False if the geometry is in the tree only because the scene compresses others: GRID traces it. */
  bool compresses() const { return isCompressed; }

  bool maxErrorSetsFrameLevel() const {
    return settings.frameLevel == RTC_COMPRESSION_FRAME_LEVEL_AUTO && settings.maxError > 0.0f && compresses() &&
           cbvh::descriptionOf(kind()).hasThickness;
  }

  enum Storage { GRID, FRAMED, VERT }; //!< Embree's GRID, blocks with frames, or cVERT

  /*! Storage of a patch, by the rates of its edges, which Embree limits to 4096. FRAMED supports 256. */
  Storage storage(const float rate[4]) const {
    const float highest = max(max(rate[0], rate[1]), max(rate[2], rate[3]));
    if (moves()) return VERT;
    if (!compresses()) return GRID;
    if (kind() == cbvh::Kind::CVERT) return VERT;
    if (highest <= float(1u << cbvh::maxFramedLevel)) return FRAMED;
    return hasFallbackFaces() ? VERT : GRID;
  }

  /*! Frame level for a patch of 2^level quads per side, unless max_error determines it. Blocks of 16 x 16 quads
   *  minimize the product of bytes and time, or nearly so (docs/paper.md): smaller blocks are hardly faster, but
   *  their frames cost more than their leaves save, and larger blocks save little and are slower. */
  unsigned frameLevel(unsigned level) const {
    if (settings.frameLevel != RTC_COMPRESSION_FRAME_LEVEL_AUTO) return unsigned(settings.frameLevel);
    return level > 4 ? level - 4 : 0;
  }

private:
  cbvh::Kind blockKind = cbvh::Kind::CGRID;
  bool isCompressed, areBlocksTiles, isFormChosen;
};
} // namespace embree::isa
