// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What geometries that can be compressed have besides what Embree gives them. A subdivision surface that does not move is compressed by
 * the scene that traces it. Subdivision surfaces that move, grids, quads and triangles are taken from Embree's own kernels when they are
 * committed: their type is then one that none of Embree's has. */

#include "../embree/geometry.h"
#include "settings.h"
#include "surface_state.h"

namespace embree
{
  class SubdivMesh;
  struct GridMesh;
  struct QuadMesh;
  struct TriangleMesh;

  class CompressibleGeometry : public Geometry
  {
  public:
    CompressibleGeometry (Device* device, GType type, unsigned numPrimitives, unsigned numTimeSteps)
      : Geometry(device,type,numPrimitives,numTimeSteps), ownType(type) {}

    /*! of geometry that is compressed when it is committed: a number that Embree leaves free */
    static const GType GTY_COMPRESSED = GType(24);

    void enable () override { surface.changeVisibility(isDisabled()); Geometry::enable(); }
    void disable () override { surface.changeVisibility(isEnabled()); Geometry::disable(); }
    void setIntersectionFilterFunctionN (RTCFilterFunctionN filter) override { surface.changeVisibility(0); Geometry::setIntersectionFilterFunctionN(filter); }
    void setOcclusionFilterFunctionN (RTCFilterFunctionN filter) override { surface.changeVisibility(0); Geometry::setOcclusionFilterFunctionN(filter); }
    void setUserData (void* ptr) override { surface.change(); Geometry::setUserData(ptr); }

    /*! whether Embree's own kernels of its type have been left for blocks */
    bool isCompressed () const { return getType() == GTY_COMPRESSED; }

    /*! takes it from Embree's kernels, or gives it back */
    void setCompressed (bool compressed) { gtype = compressed ? GTY_COMPRESSED : ownType; }

    /*! Scenes count the primitives of geometry that is compressed among those of subdivision surfaces, whose trees its blocks are in. */
    void addToCount (GeometryCounts& counts) const { (numTimeSteps == 1 ? counts.numSubdivPatches : counts.numMBSubdivPatches) += numPrimitives; }

    const GType ownType;             //!< that it was made as
    CompressionSettings compression; //!< set by rtcSetGeometryCompression
    SurfaceState surface;

  protected:
    /*! Throws if that is interpolated, and was let go. */
    void requireInput (RTCBufferType type) const;
  };

  /*! a geometry as that, or null where its type is none that can be compressed */
  inline CompressibleGeometry* compressible (Geometry* geometry)
  {
    switch (int(geometry->getType())) {
    case Geometry::GTY_SUBDIV_MESH: case Geometry::GTY_GRID_MESH: case Geometry::GTY_QUAD_MESH: case Geometry::GTY_TRIANGLE_MESH:
    case CompressibleGeometry::GTY_COMPRESSED: return static_cast<CompressibleGeometry*>(geometry);
    default: return nullptr;
    }
  }

  /*! a geometry that a scene's tree of blocks that move, or of those that do not, may have, or null: one that is enabled, and is compressed
   *  or a subdivision surface that does not move */
  inline CompressibleGeometry* geometryOfTree (Geometry* geometry, bool moves)
  {
    if (!geometry || !geometry->isEnabled() || (geometry->numTimeSteps != 1) != moves) return nullptr;
    CompressibleGeometry* const surface = compressible(geometry);
    return surface && (surface->isCompressed() || (!moves && surface->getType() == Geometry::GTY_SUBDIV_MESH)) ? surface : nullptr;
  }

  /*! Returns the data of a buffer. Throws if there is none because the input was released. */
  void* requireBuffer (Geometry* geometry, void* data);

  /*! Whether the surface is to be taken from its buffers again. Throws where they were let go. */
  bool beginCommit (SubdivMesh* mesh);
  bool beginCommit (GridMesh* mesh);
  bool beginCommit (QuadMesh* mesh);
  bool beginCommit (TriangleMesh* mesh);

  /*! Compresses a geometry that asks for it when it is committed, and lets its input go. */
  void endCommit (SubdivMesh* mesh);
  void endCommit (GridMesh* mesh);
  void endCommit (QuadMesh* mesh);
  void endCommit (TriangleMesh* mesh);
}
