// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Grids that an application diced, for GridSource (building/grid_source.h): the grids of a grid geometry
 * (GridsOfGridMesh), or regions of a quad or triangle mesh (GridsOfRegions). Both have these thread-safe members:
 *
 *   typedef Mesh, Grid
 *       Embree's geometry, and a DicedGrid. The constructor takes a const Mesh*, which must outlive the object.
 *   size_t size () const
 *       Number of grids.
 *   bool isValid (size_t i) const
 *       True if grid i has quads and all its vertices are in their buffer. operator[] and getNumbers() require that.
 *   Grid operator[] (size_t i) const
 *       The vertices of a grid, by number.
 *   const float* position (size_t vertex, unsigned step) const
 *       Position of a vertex of the buffer. May be not finite.
 *   bool hasIrregular () const
 *       True if the geometry has primitives in no grid, which may share vertices with grids.
 *   bool getNumbers (size_t i, QuadNumbers& out) const
 *       Returns false if all quads of the grid are one primitive, i. Otherwise sets their primIDs.
 *   static double spacingPerEdge ()
 *       Default spacing of lattices, as a fraction of the median edge.
 *   bool isError (size_t i) const
 *       True if a commit reports grid i as an error: it or its vertices are outside of their buffer.
 *   static size_t bytesInEmbree (size_t quadsX, size_t quadsY, unsigned numTimeSteps, Device* device)
 *       Estimated bytes that Embree's own representation of a grid needs, with all time steps. */

#include "embree_bytes.h"
#include "../base/codec_names.h"
#include "../../cvert/encoder/lattice.h"
#include "mesh_regions.h"
#include "source.h"

namespace embree::isa {
static_assert(minGridSide == QuadRegions::minRegionSide, "minGridSide must equal QuadRegions::minRegionSide");

/*! The vertices of one grid. Vertices: has width and height, in vertices, and vertex(x,y), an index in the
 *  geometry's buffer. */
template<typename Vertices>
struct DicedGrid : public Vertices {
  explicit DicedGrid(const Vertices& vertices) : Vertices(vertices) {}

  unsigned quads(int d) const { return (d == 0 ? this->width : this->height) - 1; }

  /*! Returns vertex k of side s, both numbered as in source.h. */
  size_t sideVertex(int s, unsigned k) const {
    switch (s) {
    case 0: return this->vertex(k, 0);
    case 1: return this->vertex(this->width - 1, k);
    case 2: return this->vertex(this->width - 1 - k, this->height - 1);
    default: return this->vertex(0, this->height - 1 - k);
    }
  }
};

class GridsOfGridMesh {
  struct Rows {
    size_t first, stride; //!< in vertices
    unsigned width, height;
    size_t vertex(unsigned x, unsigned y) const { return first + y * stride + x; }
  };

public:
  typedef GridMesh Mesh;
  static double spacingPerEdge() { return cbvh::spacingPerGridEdge; }
  typedef DicedGrid<Rows> Grid;

  explicit GridsOfGridMesh(const GridMesh* mesh) : mesh(mesh) {}

  size_t size() const { return mesh->size(); }
  Grid operator[](size_t i) const {
    const GridMesh::Grid& g = mesh->grid(i);
    return Grid(Rows{g.startVtxID, g.lineVtxOffset, g.resX, g.resY});
  }

  bool hasIrregular() const { return false; }

  bool isValid(size_t i) const { return i < mesh->grids.size() && hasQuads(i) && isInBuffer(i); }

  /*! Grids without quads are no errors: Embree accepts them, and programs rely on that. */
  bool isError(size_t i) const { return i >= mesh->grids.size() || (hasQuads(i) && !isInBuffer(i)); }

  const float* position(size_t vertex, unsigned step) const {
    return (const float*)mesh->vertices[step].getPtr(vertex);
  }
  bool getNumbers(size_t, cbvh::QuadNumbers&) const { return false; }

  static size_t bytesInEmbree(size_t quadsX, size_t quadsY, unsigned numTimeSteps, Device* device) {
    return bytesOfGridInEmbree(quadsX, quadsY, numTimeSteps, hasWideNodes(device));
  }

private:
  bool hasQuads(size_t i) const { return mesh->grid(i).resX > 1 && mesh->grid(i).resY > 1; }

  bool isInBuffer(size_t i) const {
    const Grid grid = (*this)[i];
    return grid.vertex(grid.width - 1, grid.height - 1) < mesh->vertices0.size();
  }

  const GridMesh* mesh;
};

/*! The regions of a mesh. Quads: QuadsOfMesh or PairsOfMesh (quad_regions.h). */
template<typename MeshType, typename Quads, size_t (*bytesOfQuad)(unsigned numTimeSteps)>
class GridsOfRegions {
  struct Corners {
    const Quads* mesh;
    const unsigned* quadsOfRegion; //!< row by row
    unsigned width, height;        //!< in vertices

    size_t vertex(unsigned x, unsigned y) const {
      const unsigned w = width - 1, right = x == w, top = y == height - 1;
      unsigned v[4];
      mesh->corners(quadsOfRegion[(y - top) * w + x - right], v);
      return v[top ? 3 - right : right];
    }
  };

public:
  typedef MeshType Mesh;
  static double spacingPerEdge() { return cbvh::spacingPerMeshEdge; }
  typedef DicedGrid<Corners> Grid;

  explicit GridsOfRegions(const MeshType* mesh)
    : regions(regionsOf(mesh)),
      reported(mesh->device, regions->bytes()),
      mesh(mesh),
      quads(quadsOf(mesh, *regions)) {}
  GridsOfRegions(const GridsOfRegions&) = delete;

  size_t size() const { return regions->regions.size(); }
  Grid operator[](size_t i) const {
    const QuadRegions::Region& r = regions->regions[i];
    return Grid(Corners{&quads, regions->quads.data() + r.first, r.width + 1, r.height + 1});
  }
  bool hasIrregular() const { return regions->hasIrregular(); }
  bool isValid(size_t) const { return true; }
  const float* position(size_t vertex, unsigned step) const {
    return (const float*)mesh->vertices[step].getPtr(vertex);
  }

  bool getNumbers(size_t i, cbvh::QuadNumbers& out) const {
    numberRegion(quads, *regions, i, out);
    return true;
  }

  /*! Embree skips quads with invalid indices without an error. */
  static bool isError(size_t) { return false; }

  static size_t bytesInEmbree(size_t quadsX, size_t quadsY, unsigned numTimeSteps, Device*) {
    return bytesOfQuad(numTimeSteps) * quadsX * quadsY;
  }

private:
  const std::shared_ptr<const QuadRegions> regions;
  const cbvh::ReportedMemory reported;
  const MeshType* const mesh;
  const Quads quads;
};

typedef GridsOfRegions<QuadMesh, QuadsOfMesh, bytesOfQuadInEmbree> GridsOfQuadMesh;
typedef GridsOfRegions<TriangleMesh, PairsOfMesh, bytesOfPairInEmbree> GridsOfTriangleMesh;
} // namespace embree::isa
