// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Regions of a mesh in which its quads lie like those of a grid, found from indices alone: what was diced is regular inside, and its
 * connectivity says so. Quads are those of a quad mesh, or pairs of triangles of a triangle mesh that follow each other and share an
 * edge. Corners of a quad are v0 to v3 around it, and Embree cuts it from v1 to v3, as it cuts the quads of grids:
 *
 *     v3 --- v2 --- .       Quad r is right of quad q if its v0 and v3 are v1 and v2 of q, and it is above q if its v0
 *      |  \  |   \  |       and v1 are v3 and v2 of q. So all quads of a region begin at the same corner, have the same two
 *     v0 --- v1 --- .       triangles as in their mesh, and a vertex of a region is one of the mesh, whichever quad is asked. */

#include "../embree/scene.h"
#include "../base/codec.h"
#include "../../cvert/format/quad_numbers.h"
#include <memory>

namespace embree
{
  /*! the quads of a quad mesh */
  struct QuadsOfMesh
  {
    const QuadMesh* mesh;

    size_t size () const { return mesh->quads.size(); }
    void corners (size_t quad, unsigned v[4]) const { memcpy(v,mesh->quads.getPtr(quad),4*sizeof(unsigned)); }

    /*! primID, and that of its second triangle less 1 */
    unsigned number (size_t quad) const { return unsigned(quad); }

    /*! see cvert/format/quad_numbers.h */
    unsigned form (size_t) const { return 0; }
  };

  /*! the pairs of triangles of a triangle mesh */
  struct PairsOfMesh
  {
    const TriangleMesh* mesh;
    const mvector<unsigned>* firsts; //!< triangles of pairs; null if pair i begins with triangle 2i

    size_t size () const { return firsts ? firsts->size() : mesh->triangles.size()/2; }
    unsigned number (size_t pair) const { return firsts ? (*firsts)[pair] : unsigned(2*pair); }

    /*! whether it is a triangle without a second one: the corner v2 is v1 then */
    bool isSingle (size_t pair) const
    {
      if (!firsts) return false;
      return (pair+1 < firsts->size() ? (*firsts)[pair+1] : mesh->triangles.size()) == size_t((*firsts)[pair]) + 1;
    }

    /*! Corners of triangles that share an edge: the first has 00, 10, 01, the second 11, 01, 10. False if they share none. */
    static bool join (const unsigned a[3], const unsigned b[3], unsigned v[4], unsigned& turns)
    {
      for (unsigned i=0; i<3; i++)
        for (unsigned j=0; j<3; j++) {
          if (a[i] != b[(j+1)%3] || a[(i+1)%3] != b[j]) continue;
          v[0] = a[(i+2)%3]; v[1] = a[i]; v[2] = b[(j+2)%3]; v[3] = b[j];
          turns = cbvh::formOfTurns((3-(i+2)%3)%3,(3-(j+2)%3)%3);
          return true;
        }
      return false;
    }

    /*! its form */
    unsigned look (size_t pair, unsigned v[4]) const
    {
      const size_t first = number(pair);
      unsigned a[3], b[3], turns = 0;
      triangle(first,a);
      if (isSingle(pair)) {
        v[0] = a[0]; v[1] = v[2] = a[1]; v[3] = a[2];
        return cbvh::numbersOfTriangles | cbvh::numbersOfOneTriangle;
      }
      triangle(first+1,b);
      join(a,b,v,turns);
      return cbvh::numbersOfTriangles | turns;
    }

    void corners (size_t pair, unsigned v[4]) const { look(pair,v); }
    unsigned form (size_t pair) const { unsigned v[4]; return look(pair,v); }

  private:
    void triangle (size_t i, unsigned v[3]) const { memcpy(v,mesh->triangles.getPtr(i),3*sizeof(unsigned)); }
  };

  struct QuadRegions
  {
    struct Region
    {
      size_t first;           //!< of its quads
      unsigned width, height; //!< in quads
    };

    /*! A region has at most so many quads along a side: its vertices have one lattice, and quads of a mesh may grow along it. */
    static const unsigned maxSide = 64;

    mvector<Region> regions;
    mvector<unsigned> quads;  //!< of each region, row by row from its v0
    mvector<unsigned> firsts; //!< of PairsOfMesh; empty if that needs none
    bool isOutOfMemory = false; //!< there was not enough to find them
    mvector<unsigned> loose;  //!< primitives of no region that are stored in mesh blocks (mesh_parts.h), ascending
    bool areAllLoose = false;   //!< there are no regions, and all primitives are loose; `loose` is empty
    size_t numLeftOut = 0;    //!< quads and triangles with an index that is no vertex, which rays do not hit

    explicit QuadRegions (Device* device) : regions(device,0), quads(device,0), firsts(device,0), loose(device,0) {}

    bool hasLoose () const { return areAllLoose || !loose.empty(); }

    PairsOfMesh pairs (const TriangleMesh* mesh) const { return PairsOfMesh{ mesh,firsts.empty() ? nullptr : &firsts }; }

    /*! Null where a look at some quads says that it is not regular. */
    static std::shared_ptr<const QuadRegions> find (const QuadMesh* mesh);
    static std::shared_ptr<const QuadRegions> find (const TriangleMesh* mesh);
  };
}
