// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* State of geometries that can be compressed, in addition to Embree's. Subdivision surfaces without motion blur are
 * compressed by the scene that traces them. Moving subdivision surfaces, grids, quads and triangles are taken from
 * Embree's own kernels when they are committed: they then have a type that Embree does not use. */

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

  /*! The surface of a geometry: its blocks, and what changed since the last commit of the geometry. */
  struct SurfaceState
  {
    std::shared_ptr<const cbvh::SurfaceNumber> number; //!< null until a scene or a commit needs it
    std::shared_ptr<const SurfaceBlocks> blocks;       //!< null until they are built, and after the surface changed
    std::shared_ptr<const QuadRegions> regions;        //!< quads and triangles: from the commit until blocks are built
    bool inputReleased = false;                        //!< RTC_COMPRESSION_FLAG_RELEASE_INPUT, or the key release_input
    const char* rejectionReason = nullptr;             //!< reason why compression was requested but not done

    /*! Records a change of the visibility. counted: number of modifications that Embree counts for it. */
    void changeVisibility (unsigned counted) { visibilityChanged = true; visibilityChanges += counted; }

    /*! Records a change of the surface or of the arguments of its displacement function that Embree may not count. */
    void change () { changed = true; }

    /*! True if blocks remain valid: since the last commit something changed, and only the visibility. If nothing
     *  changed that the library can detect, a displacement function may return other values, so blocks are rebuilt,
     *  unless the input was released. */
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

    /*! Type of geometry that is compressed when it is committed. Embree does not use this value. */
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

    /*! True if blocks are traced instead of Embree's own representation of the type. */
    bool isCompressed () const { return getType() == GTY_COMPRESSED; }

    /*! Takes the geometry from Embree's kernels, or returns it to them. */
    void setCompressed (bool compressed) { gtype = compressed ? GTY_COMPRESSED : ownType; }

    /*! Scenes count primitives of compressed geometry as primitives of subdivision surfaces, whose trees contain its
     *  blocks. */
    void addToCount (GeometryCounts& counts) const {
      (numTimeSteps == 1 ? counts.numSubdivPatches : counts.numMBSubdivPatches) += numPrimitives;
    }

    const GType ownType;             //!< type with which it was created
    CompressionSettings compression; //!< set by rtcSetGeometryCompression
    SurfaceState surface;

  protected:
    /*! Throws if a buffer of this type is interpolated and its input was released. */
    void requireInput (RTCBufferType type) const;
  };

  /*! Casts a geometry, or returns null if its type cannot be compressed. */
  inline CompressibleGeometry* compressible (Geometry* geometry)
  {
    switch (int(geometry->getType())) {
    case Geometry::GTY_SUBDIV_MESH: case Geometry::GTY_GRID_MESH: case Geometry::GTY_QUAD_MESH:
    case Geometry::GTY_TRIANGLE_MESH:
    case CompressibleGeometry::GTY_COMPRESSED: return static_cast<CompressibleGeometry*>(geometry);
    default: return nullptr;
    }
  }

  /*! Returns a geometry that a scene's tree of moving, or of static, blocks may contain, else null. It must be enabled,
   *  and either compressed or a static subdivision surface. */
  inline CompressibleGeometry* geometryOfTree (Geometry* geometry, bool moves)
  {
    if (!geometry || !geometry->isEnabled() || (geometry->numTimeSteps != 1) != moves) return nullptr;
    CompressibleGeometry* const surface = compressible(geometry);
    return surface && (surface->isCompressed() || (!moves && surface->getType() == Geometry::GTY_SUBDIV_MESH))
      ? surface : nullptr;
  }

  /*! Returns data, the data of a buffer. Throws if it is null because the input was released. */
  void* requireBuffer (Geometry* geometry, void* data);

  /*! Begins a commit. Returns true if the surface must be read from its buffers again. Throws if they were released. */
  bool beginCommit (SubdivMesh* mesh);
  bool beginCommit (GridMesh* mesh);
  bool beginCommit (QuadMesh* mesh);
  bool beginCommit (TriangleMesh* mesh);

  /*! Compresses a geometry that is compressed when it is committed, and releases its input. */
  void endCommit (SubdivMesh* mesh);
  void endCommit (GridMesh* mesh);
  void endCommit (QuadMesh* mesh);
  void endCommit (TriangleMesh* mesh);
}
