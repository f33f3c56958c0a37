// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What all patches of a geometry have in common, and by the edge rates of a patch how it is stored. Geometry that comes
 * diced or moves is stored as cVERT, whatever kind is asked for. */

#include "../embree/scene.h"
#include "../base/kinds.h"

namespace embree
{
  namespace isa
  {
    struct CompressionPlan
    {
      uint32_t surface;              //!< number of the surface, surface_ids.h
      unsigned numTimeSteps;
      BBox1f timeRange;
      CompressionSettings settings;  //!< resolved

      CompressionPlan (const CompressibleGeometry* geometry, uint32_t number)
        : surface(number | (geometry->numTimeSteps != 1 ? cbvh::movingSurface : 0)), numTimeSteps(geometry->numTimeSteps), timeRange(geometry->time_range),
          settings(geometry->compression.resolve(geometry->device->compression))
      {
        isCompressed = cbvh::findKind(settings.compression,blockKind);
        if (geometry->isCompressed() || moves()) blockKind = cbvh::Kind::VERT;
      }

      /*! whether a geometry that asks for compression gets it if it moves */
      static bool takesMotion (const CompressibleGeometry* geometry)
      {
        const CompressionSettings settings = geometry->compression.resolve(geometry->device->compression);
        return settings.compression == RTC_COMPRESSION_VERT || settings.exactFaces != 0;
      }

      bool moves () const { return numTimeSteps != 1; }

      /*! whether vertices are stored as they come */
      bool isLossless () const { return kind() == cbvh::Kind::VERT && settings.maxError == 0.0f; }

      /*! only if compresses() */
      cbvh::Kind kind () const { return blockKind; }

      /*! The setting exact_faces: patches that frames hold badly are stored as cVERT. */
      bool hasExactFaces () const { return compresses() && kind() == cbvh::Kind::LEAF && settings.exactFaces != 0; }

      /*! whether faces take the vertices of their borders from the face that owns them */
      bool sharesBorders () const { return compresses() && (kind() == cbvh::Kind::VERT || hasExactFaces()); }

      bool compresses () const { return isCompressed; }

      /*! whether frame levels follow from the geometry itself */
      bool boundsError () const {
        return settings.frameLevel == RTC_COMPRESSION_FRAME_LEVEL_AUTO && settings.maxError > 0.0f && compresses() && cbvh::describe(kind()).hasThickness;
      }

      /*! How a patch is stored: as Embree's GRID, in blocks with frames, or as cVERT. */
      enum Storage { GRID, FRAMED, VERT };

      Storage storage (const float rate[4]) const
      {
        const float highest = max(max(rate[0],rate[1]),max(rate[2],rate[3]));
        if (moves()) return VERT; // Embree's highest rate is ours
        if (!compresses()) return GRID;
        if (kind() == cbvh::Kind::VERT) return highest <= float(cbvh::maxVertRate) ? VERT : GRID;
        if (highest <= float(1u << cbvh::maxLevel)) return FRAMED;
        return hasExactFaces() && highest <= float(cbvh::maxVertRate) ? VERT : GRID;
      }

      /*! Frame level without an error bound. Of all levels and scenes that were measured, blocks of 16 x 16 quads
       *  cost least in bytes times time, or nearly so (docs/paper.md): smaller ones are hardly faster, and their
       *  frames outweigh what leaves save; larger ones save little and are slower. */
      unsigned frameLevel (unsigned level) const
      {
        if (settings.frameLevel != RTC_COMPRESSION_FRAME_LEVEL_AUTO) return unsigned(settings.frameLevel);
        return level > 4 ? level-4 : 0;
      }

    private:
      cbvh::Kind blockKind = cbvh::Kind::GRID;
      bool isCompressed;
    };
  }
}
