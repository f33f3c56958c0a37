// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* State of geometries that can be compressed, in addition to Embree's. Scenes compress subdivision surfaces without
 * motion blur. Commits compress moving subdivision surfaces, grids, quads and triangles, and give them a type that
 * Embree's kernels ignore. */

#include "../embree/geometry.h"
#include "settings.h"
#include <memory>

namespace embree
{
  class SubdivMesh;
  struct GridMesh;
  struct QuadMesh;
  struct TriangleMesh;
  struct SurfaceBlocks;
  struct QuadRegions;
  namespace cbvh { class SurfaceNumber; }

  /*! A geometry's blocks, and what changed since its last commit. */
  struct SurfaceState
  {
    std::shared_ptr<const cbvh::SurfaceNumber> number; //!< null until needed
    std::shared_ptr<const SurfaceBlocks> blocks;       //!< null until built, and after a change
    std::shared_ptr<const QuadRegions> regions;        //!< quads and triangles: from the commit until blocks are built
    bool inputReleased = false;                        //!< RTC_COMPRESSION_FLAG_RELEASE_INPUT, or the key release_input
    const char* rejectionReason = nullptr;             //!< why compression was requested but not done

    /*! counted: modifications that Embree counts for a change of visibility. */
    void changeVisibility (unsigned counted) { visibilityChanged = true; visibilityChanges += counted; }

    /*! Records a change of the surface, or of arguments of its displacement function, that Embree may not count. */
    void change () { changed = true; }

    /*! True if blocks remain valid: only the visibility changed since the last commit. If no change was detected,
     *  blocks are rebuilt, because a displacement function may return other values, unless the input was released. */
    bool isKept (unsigned modCounter) const {
      return (visibilityChanged || (inputReleased && blocks)) && !changed
        && modCounter - committedModCounter == visibilityChanges;
    }

    void commit (unsigned modCounter)
    {
      visibilityChanged = changed = false;
      visibilityChanges = 0;
      committedModCounter = modCounter;
    }

  private:
    bool visibilityChanged = false, changed = false;
    unsigned visibilityChanges = 0, committedModCounter = 0;
  };

  class CompressibleGeometry : public Geometry
  {
  public:
    CompressibleGeometry (Device* device, GType type, unsigned numPrimitives, unsigned numTimeSteps)
      : Geometry(device,type,numPrimitives,numTimeSteps), ownType(type) {}

    /*! Type of geometry that commits compress. Embree does not use this value. */
    static const GType GTY_COMPRESSED = GType(24);

    void enable () override { surface.changeVisibility(isDisabled()); Geometry::enable(); }
    void disable () override { surface.changeVisibility(isEnabled()); Geometry::disable(); }
    void setIntersectionFilterFunctionN (RTCFilterFunctionN filter) override {
      surface.changeVisibility(0);
      Geometry::setIntersectionFilterFunctionN(filter);
    }
    void setOcclusionFilterFunctionN (RTCFilterFunctionN filter) override {
      surface.changeVisibility(0);
      Geometry::setOcclusionFilterFunctionN(filter);
    }
    void setUserData (void* ptr) override { surface.change(); Geometry::setUserData(ptr); }

    /*! True if blocks are traced instead of Embree's representation. */
    bool isCompressed () const { return getType() == GTY_COMPRESSED; }

    /*! False returns the geometry to Embree's kernels. */
    void setCompressed (bool compressed) { gtype = compressed ? GTY_COMPRESSED : ownType; }

    /*! Counts compressed geometry as subdivision surfaces, whose trees contain its blocks. */
    void addToCount (GeometryCounts& counts) const {
      (numTimeSteps == 1 ? counts.numSubdivPatches : counts.numMBSubdivPatches) += numPrimitives;
    }

    const GType ownType;             //!< type at creation
    CompressionSettings compression; //!< set by rtcSetGeometryCompression
    SurfaceState surface;

  protected:
    /*! Throws if interpolation needs released input. */
    void requireInput (RTCBufferType type) const;
  };

  /*! Null for types that cannot be compressed. */
  inline CompressibleGeometry* compressible (Geometry* geometry)
  {
    switch (int(geometry->getType())) {
    case Geometry::GTY_SUBDIV_MESH: case Geometry::GTY_GRID_MESH: case Geometry::GTY_QUAD_MESH:
    case Geometry::GTY_TRIANGLE_MESH:
    case CompressibleGeometry::GTY_COMPRESSED: return static_cast<CompressibleGeometry*>(geometry);
    default: return nullptr;
    }
  }

  /*! Null unless a scene's tree of moving, or static, blocks may contain the geometry: it must be enabled, and
   *  compressed or a static subdivision surface. */
  inline CompressibleGeometry* geometryOfTree (Geometry* geometry, bool moves)
  {
    if (!geometry || !geometry->isEnabled() || (geometry->numTimeSteps != 1) != moves) return nullptr;
    CompressibleGeometry* const surface = compressible(geometry);
    return surface && (surface->isCompressed() || (!moves && surface->getType() == Geometry::GTY_SUBDIV_MESH))
      ? surface : nullptr;
  }

  /*! Returns data, a buffer's contents. Throws if it is null because the input was released. */
  void* requireBuffer (Geometry* geometry, void* data);

  /*! Begins a commit. True if the surface must be read again. Throws if its buffers were released. */
  bool beginCommit (SubdivMesh* mesh);
  bool beginCommit (GridMesh* mesh);
  bool beginCommit (QuadMesh* mesh);
  bool beginCommit (TriangleMesh* mesh);

  /*! Compresses a geometry if commits do so for its type, and releases its input. */
  void endCommit (SubdivMesh* mesh);
  void endCommit (GridMesh* mesh);
  void endCommit (QuadMesh* mesh);
  void endCommit (TriangleMesh* mesh);
}
