// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Regions of a mesh whose quads form a grid, found from connectivity alone. Most need fewer bytes as grids than as
 * mesh blocks. Vertices with the same position may count as one (welded_vertices.h). In a triangle mesh, quads are
 * pairs of triangles that share an edge (triangle_pairs.h). The corners v0 to v3 go around a quad. Embree splits it
 * from v1 to v3, like the quads of grids:
 *
 *    v3 --- v2 --- .       Quad r is right of quad q if its v0 and v3 are v1 and v2 of q. It is above q if its v0 and
 *     |  \  |   \  |       v1 are v3 and v2 of q. So all quads of a region begin at the same corner, and have the same
 *    v0 --- v1 --- .       triangles as in their mesh. */

#include "../embree/scene.h"
#include "../base/codec_names.h"
#include "../../cvert/encoder/prim_id_encoder.h"
#include "welded_vertices.h"
#include <memory>

namespace embree {
inline namespace CBVH_ISA {
struct QuadsOfMesh {
  const QuadMesh* mesh;
  const WeldedVertices* welded; //!< null: vertices are matched by index

  size_t size() const { return mesh->quads.size(); }

  void corners(size_t quad, unsigned v[4]) const {
    memcpy(v, mesh->quads.getPtr(quad), 4 * sizeof(unsigned));
    if (welded)
      for (int i = 0; i < 4; i++) v[i] = (*welded)[v[i]];
  }

  unsigned firstPrimID(size_t quad) const { return unsigned(quad); }  //!< primID of the quad
  unsigned secondPrimID(size_t quad) const { return unsigned(quad); } //!< primID of its second triangle: the same

  /*! Numbering of the quad (cvert/format/prim_ids.h): 0 for quad meshes. */
  unsigned numbering(size_t) const { return 0; }

  unsigned cornersAndNumbering(size_t quad, unsigned v[4]) const {
    corners(quad, v);
    return numbering(quad);
  }
};

/*! Pairs of triangles, as quads. A triangle without a partner is a pair whose second triangle is the first. */
struct PairsOfMesh {
  const TriangleMesh* mesh;
  const WeldedVertices* welded;     //!< null: vertices are matched by index
  const mvector<unsigned>* firsts;  //!< first triangle of each pair; null if it is 2i for pair i
  const mvector<unsigned>* seconds; //!< second triangle of each pair; null if it follows the first one

  size_t size() const { return firsts ? firsts->size() : mesh->triangles.size() / 2; }
  unsigned firstPrimID(size_t pair) const { return firsts ? (*firsts)[pair] : unsigned(2 * pair); }

  /*! The second triangle of a pair; firstPrimID(pair) if there is none. */
  unsigned secondPrimID(size_t pair) const {
    if (seconds) return (*seconds)[pair];
    const unsigned first = firstPrimID(pair);
    if (!firsts) return first + 1;
    const size_t next = pair + 1 < firsts->size() ? (*firsts)[pair + 1] : mesh->triangles.size();
    return next == size_t(first) + 1 ? first : first + 1;
  }

  /*! Joins two triangles to a quad, with corners 00, 10, 01 and 11, 01, 10 (digits: u, v). firstCorners: receives
   *  the corners with which the triangles begin (cvert/format/prim_ids.h). Returns false unless they share an
   *  edge in opposite directions. */
  static bool join(const unsigned a[3], const unsigned b[3], unsigned v[4], unsigned& firstCorners) {
    for (unsigned i = 0; i < 3; i++)
      for (unsigned j = 0; j < 3; j++) {
        if (a[i] != b[(j + 1) % 3] || a[(i + 1) % 3] != b[j]) continue;
        v[0] = a[(i + 2) % 3];
        v[1] = a[i];
        v[2] = b[(j + 2) % 3];
        v[3] = b[j];
        firstCorners = cbvh::packFirstCorners((3 - (i + 2) % 3) % 3, (3 - (j + 2) % 3) % 3);
        return true;
      }
    return false;
  }

  /*! True if join() succeeds, and all vertices exist. */
  bool shareEdge(size_t first, size_t second) const {
    unsigned a[3], b[3], v[4], firstCorners;
    triangle(first, a);
    triangle(second, b);
    return join(a, b, v, firstCorners) && max(max(v[0], v[1]), max(v[2], v[3])) < mesh->numVertices();
  }

  unsigned cornersAndNumbering(size_t pair, unsigned v[4]) const {
    const unsigned first = firstPrimID(pair), other = secondPrimID(pair);
    unsigned a[3], b[3], firstCorners = 0;
    triangle(first, a);
    if (other == first) { // for a single triangle, v2 equals v1
      v[0] = a[0];
      v[1] = v[2] = a[1];
      v[3] = a[2];
      return cbvh::primIDsOfTriangles | cbvh::primIDsOfOneTriangle;
    }
    triangle(other, b);
    join(a, b, v, firstCorners);
    return cbvh::primIDsOfTriangles | firstCorners;
  }

  void corners(size_t pair, unsigned v[4]) const { cornersAndNumbering(pair, v); }
  unsigned numbering(size_t pair) const {
    unsigned v[4];
    return cornersAndNumbering(pair, v);
  }

  void triangle(size_t i, unsigned v[3]) const {
    memcpy(v, mesh->triangles.getPtr(i), 3 * sizeof(unsigned));
    if (welded)
      for (int k = 0; k < 3; k++) v[k] = (*welded)[v[k]];
  }
};
} // namespace CBVH_ISA

/*! The regions of a mesh, and its primitives that are in no region. Result of find(), which divideMesh()
 *  completes (mesh_regions.h). */
struct QuadRegions {
  struct Region {
    size_t first;           //!< index of its first quad in `quads`
    unsigned width, height; //!< size in quads
  };

  /*! Quads per side. A region has one lattice, but the size of quads may change along it. */
  static const unsigned maxSide = 64;

  /*! Quads of regions with shorter sides are irregular. A block needs 138 bytes and about 5 per quad: 20 per quad for
   *  3 x 3 quads, 14 for 4 x 4, and 6 for 16 x 16. */
  static const unsigned minRegionSide = 4;

  cbvh::UnmonitoredVector<Region> regions;           //!< regular ones first; empty for an irregular mesh
  size_t numRegular = 0;                             //!< number of regions without irregular quads
  cbvh::UnmonitoredVector<unsigned> quads;           //!< by region, row by row from the region's corner v0
  std::shared_ptr<const WeldedVertices> welded;      //!< null: vertices are matched by index
  cbvh::UnmonitoredVector<unsigned> firsts, seconds; //!< as in PairsOfMesh; empty if those are null
  bool firstCornersDiffer = false;                   //!< triangles of a region's quads begin at different corners
  bool isOutOfMemory = false;                        //!< memory ran out while regions were searched
  cbvh::UnmonitoredVector<unsigned> irregular;       //!< primitives in mesh blocks (mesh_regions.h), ascending
  bool areAllIrregular = false;                      //!< all primitives are in mesh blocks; `irregular` is empty
  size_t numInvalid = 0; //!< primitives with an index that is not a vertex, if regions were found

  size_t bytes() const {
    return regions.size() * sizeof(Region) + (welded ? welded->bytes() : 0) +
           (quads.size() + firsts.size() + seconds.size() + irregular.size()) * sizeof(unsigned);
  }

  bool hasIrregular() const { return areAllIrregular || !irregular.empty(); }

  /*! Estimated bytes of the regions as grids, with their share of the tree but without tables of numbers. */
  size_t bytesOfBlocks() const;

  /*! Same for a mesh with one time step, whose regions are stored in mesh blocks if that needs fewer bytes. */
  size_t bytesWithMeshBlocks() const;

  /*! True if a region needs at most as many bytes in mesh blocks as in a grid. tables: result of bytesOfTables(), or
   *  0 to ignore tables. */
  static bool isSmallerInMeshBlocks(const Region& region, size_t tables = 0);

  /*! True if isSmallerInMeshBlocks() depends on `tables`. */
  static bool dependsOnTables(const Region& region);

  size_t numQuads(size_t beginRegion, size_t endRegion) const;

  /*! Finds the regions of a mesh. Never null; has no regions if a sample of the mesh is not regular. The result is
   *  independent of the number of threads. Throws std::bad_alloc. */
  static std::shared_ptr<const QuadRegions> find(const QuadMesh* mesh);
  static std::shared_ptr<const QuadRegions> find(const TriangleMesh* mesh);

private:
  /*! Maximum of bytesOfTables() per quad. */
  static const size_t maxTableBytes = 8;
};

inline namespace CBVH_ISA {
inline QuadsOfMesh quadsOf(const QuadMesh* mesh, const QuadRegions& meshRegions) {
  return QuadsOfMesh{mesh, meshRegions.welded.get()};
}

inline PairsOfMesh quadsOf(const TriangleMesh* mesh, const QuadRegions& meshRegions) {
  auto ofPairs = [](const mvector<unsigned>& triangles) { return triangles.empty() ? nullptr : &triangles; };
  return PairsOfMesh{mesh, meshRegions.welded.get(), ofPairs(meshRegions.firsts), ofPairs(meshRegions.seconds)};
}

/*! Sets `out` to the numbers of a region's quads, from which the encoder finds a pattern. quads: result of
 *  quadsOf(). */
template<typename Quads>
void numberRegion(const Quads& quads, const QuadRegions& meshRegions, size_t region, cbvh::QuadNumbers& out) {
  const QuadRegions::Region& r = meshRegions.regions[region];
  const unsigned* const at = meshRegions.quads.data() + r.first;
  const size_t n = size_t(r.width) * r.height;
  out.numbering = quads.numbering(*at);
  out.width = r.width;
  out.numbers.resize(n);
  for (size_t k = 0; k < n; k++) out.numbers[k] = quads.firstPrimID(at[k]);
  const bool areAllAlike = meshRegions.seconds.empty() && !meshRegions.firstCornersDiffer;
  const bool needSeconds =
      !areAllAlike && cbvh::isTriangleNumbering(out.numbering) && !cbvh::isSingleTriangleNumbering(out.numbering);
  out.seconds.resize(needSeconds ? n : 0);
  out.firstCorners.resize(needSeconds ? n : 0);
  if (!needSeconds) return;
  const unsigned firstCorners = cbvh::packFirstCorners(3, 3);
  out.numbering &= ~firstCorners;
  for (size_t k = 0; k < n; k++) {
    out.seconds[k] = quads.secondPrimID(at[k]);
    out.firstCorners[k] = uint8_t(quads.numbering(at[k]) & firstCorners);
  }
}

/*! Estimated bytes of a region's tables of numbers, as if all blocks were like the first one; 0 if the numbers have
 *  a pattern. numbers, encoder: temporary memory. */
template<typename Quads>
size_t bytesOfTables(const Quads& quads, const QuadRegions& meshRegions, size_t region, cbvh::QuadNumbers& numbers,
                     cbvh::NumbersEncoder& encoder) {
  const QuadRegions::Region& r = meshRegions.regions[region];
  const unsigned side = cbvh::vertBlockQuads;
  numberRegion(quads, meshRegions, region, numbers);
  encoder.choosePattern(numbers, 0, 0, min(r.width, side), min(r.height, side));
  if (!cbvh::haveTable(encoder.numbering)) return 0;
  return size_t(r.width) * r.height * cbvh::entriesPerQuad(encoder.numbering) * encoder.pattern.y / 8;
}
} // namespace CBVH_ISA
} // namespace embree
