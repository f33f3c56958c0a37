// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What all patches of a geometry have in common, and how the edge rates of a patch
 * decide into which blocks it is cut. */

#include "../embree/scene.h"
#include "../base/kinds.h"
#include "../vert/format.h"

namespace embree
{
  namespace isa
  {
    /*! A patch in blocks with frames, of 2^height x 2^height quads. Along u and v it has as many as
     *  it takes for the higher rate of its two opposite edges:
     *
     *       rate 9
     *     +---+---+---+
     *     |   |   |   |    height 2: 3 x 2 blocks, 12 x 8 quads
     *   8 +---+---+---+ 5
     *     |   |   |   |    Edges of a lower rate keep their own vertices (patch_grid.h).
     *     +---+---+---+
     *       rate 3                                                                 */
    struct PatchTiling
    {
      unsigned height = 0;
      unsigned x = 0, y = 0; //!< blocks
      Vec2i quads = Vec2i(0); //!< of all blocks

      size_t size () const { return size_t(x)*size_t(y); }
      unsigned quadsX () const { return unsigned(quads.x); }
      unsigned quadsY () const { return unsigned(quads.y); }
    };

    struct CompressionPlan
    {
      SubdivMesh* mesh;
      unsigned geomID;
      CompressionSettings settings;  //!< resolved

      CompressionPlan (Scene* scene, SubdivMesh* mesh, unsigned geomID)
        : mesh(mesh), geomID(geomID), settings(mesh->compression.resolve(scene->device->compression)),
          isCompressed(cbvh::findKind(settings.compression,blockKind)) {}

      /*! only if compresses() */
      cbvh::Kind kind () const { return blockKind; }

      /*! whether patches that frames hold badly are stored as cVERT */
      bool hasExactFaces () const { return compresses() && kind() == cbvh::Kind::LEAF && settings.exactFaces != 0; }

      /*! whether faces take the vertices of their borders from the face that owns them */
      bool sharesBorders () const { return compresses() && (kind() == cbvh::Kind::VERT || hasExactFaces()); }

      bool compresses () const { return isCompressed; }

      /*! whether frame levels follow from the geometry itself */
      bool boundsError () const {
        return settings.frameLevel == RTC_COMPRESSION_FRAME_LEVEL_AUTO && settings.maxError > 0.0f && compresses() && cbvh::describe(kind()).hasThickness;
      }

      /*! how a patch is stored */
      enum Storage { GRIDS, FRAMED, EXACT };

      Storage storage (const float rate[4]) const
      {
        const float highest = max(max(rate[0],rate[1]),max(rate[2],rate[3]));
        if (!compresses()) return GRIDS;
        if (kind() == cbvh::Kind::VERT) return highest <= float(cbvh::maxVertRate) ? EXACT : GRIDS;
        if (highest <= float(1u << cbvh::maxLevel)) return FRAMED;
        return hasExactFaces() && highest <= float(cbvh::maxVertRate) ? EXACT : GRIDS;
      }

      /*! Subdivision level of a patch in frames: 2^level is its highest rate or next above it. */
      unsigned level (const float rate[4]) const
      {
        unsigned level = 0;
        const float highest = max(max(rate[0],rate[1]),max(rate[2],rate[3]));
        while (level < cbvh::maxLevel && float(1u << level) < highest) level++;
        return level;
      }

      /*! Frame level without an error bound. Of all levels and scenes that were measured, blocks of 16 x 16 quads
       *  cost least in bytes times time, or nearly so (PERFORMANCE.md): smaller ones are hardly faster, and their
       *  frames outweigh what leaves save; larger ones save little and are slower. */
      unsigned frameLevel (unsigned level) const
      {
        if (settings.frameLevel != RTC_COMPRESSION_FRAME_LEVEL_AUTO) return unsigned(settings.frameLevel);
        return level > 4 ? level-4 : 0;
      }

      /*! Tiling of a patch in frames, at a frame level: blocks of 2^(level-frameLevel) quads a side,
       *  or smaller ones where they take fewer bytes, as for a long and narrow patch or
       *  a rate just above a multiple. */
      PatchTiling tiling (const float rate[4], unsigned frameLevel) const
      {
        const unsigned level = this->level(rate);
        PatchTiling best;
        const Vec2i quads = SubdivPatch1Base::computeGridSize(rate) - Vec2i(1);
        for (unsigned height=0; height <= level-min(frameLevel,level); height++)
        {
          const PatchTiling t = tilingOf(quads,height);
          if (best.size() == 0 || bytes(t) <= bytes(best)) best = t;
        }
        return best;
      }

    private:
      static PatchTiling tilingOf (const Vec2i& quads, unsigned height)
      {
        PatchTiling t;
        t.height = height;
        t.x = (unsigned(quads.x-1) >> height) + 1;
        t.y = (unsigned(quads.y-1) >> height) + 1;
        t.quads = Vec2i(int(t.x << height),int(t.y << height));
        return t;
      }

      size_t bytes (const PatchTiling& t) const { return t.size()*cbvh::blockLayout(uint32_t(kind()),t.height).stride; }

      cbvh::Kind blockKind = cbvh::Kind::GRID;
      bool isCompressed;
    };
  }
}
