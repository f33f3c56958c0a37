// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* State of geometries that can be compressed, in addition to Embree's. The commit of a geometry changes the type of
 * compressed grids, meshes and moving cages to GTY_COMPRESSED, which Embree's kernels ignore. Static cages keep their
 * type: if a scene compresses any static geometry, its compressed tree contains all of them. The commit of a scene
 * builds the blocks, unless endCommit() has. */

#include "../embree/geometry.h"
#include "settings.h"
#include <memory>

namespace embree {
class SubdivMesh;
struct GridMesh;
struct QuadMesh;
struct TriangleMesh;
struct SurfaceBlocks;
struct QuadRegions;
namespace cbvh {
class SurfaceNumber;
}

/*! A geometry's blocks, and what changed since its last commit. */
struct SurfaceState {
  std::shared_ptr<const cbvh::SurfaceNumber> number; //!< null until needed
  std::shared_ptr<const SurfaceBlocks> blocks;       //!< null until built; a commit resets outdated ones
  std::shared_ptr<const QuadRegions> regions;        //!< of a mesh, until blocks are built; use atomic_load
  bool inputReleased = false;                        //!< blocks cannot be rebuilt; also if loaded from a file
  const char* rejectionReason = nullptr;             //!< why a request was rejected ("": no input), or null

  /*! Records a change of the mask, a filter or the enabled state, after which blocks remain valid. counted: 1 if
   *  Embree increments the geometry's modCounter_ for it, otherwise 0. */
  void changeVisibility(unsigned counted) {
    visibilityChanged = true;
    visibilityChanges += counted;
  }

  /*! Records a change of the surface that Embree may not count. */
  void change() { changed = true; }
  bool isChanged() const { return changed; } //!< change() was called since the last commit
  void changeUserData() { userDataChanged = true; }

  /*! True if blocks remain valid, because only the visibility changed since the last commit. A commit without a
   *  detected change rebuilds blocks, because the displacement function may return other values, unless the input was
   *  released. */
  bool areBlocksValid(unsigned modCounter) const {
    return (visibilityChanged || (inputReleased && blocks)) && !changed && !userDataChanged &&
           modCounter - committedModCounter == visibilityChanges;
  }

  /*! Ends a commit. Later changes are relative to it. */
  void commit(unsigned modCounter) {
    visibilityChanged = changed = userDataChanged = false;
    visibilityChanges = 0;
    committedModCounter = modCounter;
  }

private:
  bool visibilityChanged = false, changed = false, userDataChanged = false;
  unsigned visibilityChanges = 0, committedModCounter = 0;
};

class CompressibleGeometry : public Geometry {
public:
  CompressibleGeometry(Device* device, GType type, unsigned numPrimitives, unsigned numTimeSteps)
    : Geometry(device, type, numPrimitives, numTimeSteps),
      ownType(type) {}

  /*! Type of compressed geometry, except for static cages not from a file. Embree does not use this value. */
  static const GType GTY_COMPRESSED = GType(24);

  void enable() override {
    if (isDisabled()) surface.changeVisibility(1);
    Geometry::enable();
  }
  void disable() override {
    if (isEnabled()) surface.changeVisibility(1);
    Geometry::disable();
  }
  void setIntersectionFilterFunctionN(RTCFilterFunctionN filter) override {
    surface.changeVisibility(0);
    Geometry::setIntersectionFilterFunctionN(filter);
  }
  void setOcclusionFilterFunctionN(RTCFilterFunctionN filter) override {
    surface.changeVisibility(0);
    Geometry::setOcclusionFilterFunctionN(filter);
  }
  void setUserData(void* ptr) override {
    surface.changeUserData();
    Geometry::setUserData(ptr);
  }

  /*! True if blocks are traced instead of Embree's representation. False for static cages not from a file, about
   *  which each scene decides (cbvh::hasCompressedGeometry). */
  bool isCompressed() const { return getType() == GTY_COMPRESSED; }

  /*! False returns the geometry to Embree's kernels. */
  void setCompressed(bool compressed) { gtype = compressed ? GTY_COMPRESSED : ownType; }

  /*! Counts compressed geometry as subdivision surfaces: scenes then create the tree that contains its blocks. */
  void addToCount(GeometryCounts& counts) const {
    (numTimeSteps == 1 ? counts.numSubdivPatches : counts.numMBSubdivPatches) += numPrimitives;
  }

  const GType ownType;             //!< type at creation
  CompressionSettings compression; //!< set by core::setCompression(), or from a file
  SurfaceState surface;

protected:
  /*! Throws if interpolation of this type of buffer needs released input. */
  void requireInput(RTCBufferType type) const;
};

/*! Returns null for types that cannot be compressed. */
inline CompressibleGeometry* asCompressible(Geometry* geometry) {
  switch (int(geometry->getType())) {
  case Geometry::GTY_SUBDIV_MESH:
  case Geometry::GTY_GRID_MESH:
  case Geometry::GTY_QUAD_MESH:
  case Geometry::GTY_TRIANGLE_MESH:
  case CompressibleGeometry::GTY_COMPRESSED: return static_cast<CompressibleGeometry*>(geometry);
  default: return nullptr;
  }
}

/*! Returns the geometry if a scene's tree of moving, or static, blocks may contain it: it is enabled, and compressed
 *  or a static cage. Otherwise null. geometry: may be null. */
inline CompressibleGeometry* asTreeGeometry(Geometry* geometry, bool moves) {
  if (!geometry || !geometry->isEnabled() || (geometry->numTimeSteps != 1) != moves) return nullptr;
  CompressibleGeometry* const compressible = asCompressible(geometry);
  return compressible &&
                 (compressible->isCompressed() || (!moves && compressible->getType() == Geometry::GTY_SUBDIV_MESH))
             ? compressible
             : nullptr;
}

/*! Returns data, the contents of a buffer. Throws if it is null and the input was released. */
void* requireBuffer(Geometry* geometry, void* data);

/*! Begins the commit of a geometry: checks its buffers, and decides whether it is compressed. Returns true if Embree
 *  must read the buffers again. Throws rtcore_error if buffers are invalid, or were released and not set again, or if
 *  endCommit() is building blocks of the geometry. */
bool beginCommit(SubdivMesh* mesh);
bool beginCommit(GridMesh* mesh);
bool beginCommit(QuadMesh* mesh);
bool beginCommit(TriangleMesh* mesh);

/*! Ends the commit of a geometry. If it is compressed and its settings request the release of its input, builds its
 *  blocks and releases the input. */
void endCommit(SubdivMesh* mesh);
void endCommit(GridMesh* mesh);
void endCommit(QuadMesh* mesh);
void endCommit(TriangleMesh* mesh);
} // namespace embree
