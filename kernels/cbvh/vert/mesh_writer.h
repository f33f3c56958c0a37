// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rounds, encodes and stores clusters of triangles as mesh blocks. */

#include "../base/block_store.h"
#include "../base/build_statistics.h"
#include "../surface/irregular_triangles.h"
#include "../../cvert/encoder/mesh_encoder.h"

namespace embree
{
  namespace isa
  {
    class MeshWriter
    {
    public:
      static const uint32_t groupTriangles = 16; //!< triangles of a full group

      MeshWriter (const IrregularTriangles& from, uint32_t surface, BlockStore& store,
        cbvh::BuildStatistics& statistics)
        : from(from), surface(surface), store(store), statistics(statistics) {}

      static uint32_t groupPrimitives (const TrianglesOfMesh& mesh) { return groupTriangles/mesh.perPrimitive; }

      /*! Writes a cluster of MeshClusters. The caller must flush the store after a part's last cluster: the part's
       *  blocks are one piece of memory. */
      void write (const cbvh::MeshCenter* cluster, const cbvh::MeshGroups& groups)
      {
        double moved = 0;
        uint32_t n = 0;
        const cbvh::MeshGroups stored = storeGroups(groups,n,[&](uint32_t i) {
          for (uint32_t k=0; k<from.mesh.perPrimitive; k++) {
            cbvh::MeshTriangle& triangle = triangles[n];
            triangle.number = from.mesh.triangleOf(cluster[i].index,k);
            if (from.mesh.areHalvesOfQuads() && from.isDegenerate(triangle.number)) continue; // half of a quad
            moved = max(moved,from.store(triangle.number,triangle.corners));
            n += hasThreeCorners(triangle); // a grid's lattice can be too coarse for an adjacent triangle
          }
        });
        statistics.addDeviation(moved);
        if (n == 0) return;
        cbvh::MeshStatistics ofBlocks;
        encoder.encodeCluster(triangles,stored,from.mesh.areHalvesOfQuads(),surface,block,ofBlocks,
          [&](size_t bytes, uint32_t first, uint32_t stored) { add(bytes,triangles+first,stored); });
      }

      /*! Calls storePrimitive(i) for each primitive of a cluster, which increases numTriangles by the triangles that it
       *  stores. Returns the groups of stored triangles. */
      template<typename StorePrimitive>
      static cbvh::MeshGroups storeGroups (const cbvh::MeshGroups& groups, const uint32_t& numTriangles,
                                           const StorePrimitive& storePrimitive)
      {
        cbvh::MeshGroups stored;
        uint32_t i = 0;
        for (uint32_t g=0; g<groups.count; g++) {
          const uint32_t before = numTriangles;
          while (i < groups.ends[g]) storePrimitive(i++);
          if (numTriangles != before) stored.add(numTriangles);
        }
        return stored;
      }

      static void addBlock (const cbvh::MeshHeader& header, size_t bytes, cbvh::BuildStatistics& statistics)
      {
        const cbvh::MeshLayout layout = cbvh::meshLayout(header.counts);
        const size_t stride = (bytes + cbvh::blockAlignment-1) & ~size_t(cbvh::blockAlignment-1);
        cbvh::CompressionStatistics& sums = statistics.sums;
        sums.headerBytes += layout.boxes;
        sums.nodeBytes += layout.topology - layout.boxes;
        sums.leafBytes += stride - layout.topology;
        sums.numBlocks++;
      }

    private:
      static bool hasThreeCorners (const cbvh::MeshTriangle& triangle)
      {
        auto areEqual = [](const float* p, const float* q) { return p[0] == q[0] && p[1] == q[1] && p[2] == q[2]; };
        const float (&c)[3][3] = triangle.corners;
        return !areEqual(c[0],c[1]) && !areEqual(c[1],c[2]) && !areEqual(c[2],c[0]);
      }

      void add (size_t bytes, const cbvh::MeshTriangle* blockTriangles, uint32_t count)
      {
        cbvh::WorldBounds bounds;
        for (uint32_t i=0; i<count; i++)
          for (const float (&p)[3] : blockTriangles[i].corners) bounds.extend(p[0],p[1],p[2]);
        if (from.mesh.areHalvesOfQuads()) ((cbvh::MeshHeader*)block)->form |= cbvh::meshHasQuads;
        memcpy(store.reserve(bytes),block,bytes);
        store.commit(bytes,toBBox(bounds),cbvh::MESH_BLOCK,cbvh::readPastVert);
        store.hitBounds.extend(bounds);
        addBlock(*(const cbvh::MeshHeader*)block,bytes,statistics);
      }

      const IrregularTriangles& from;
      const uint32_t surface;
      BlockStore& store;
      cbvh::BuildStatistics& statistics;
      cbvh::MeshEncoder encoder;
      cbvh::MeshTriangle triangles[cbvh::maxMeshTriangles+1]; //!< the last entry is for rejected triangles
      alignas(16) uint8_t block[cbvh::MeshEncoder::maxBytes];
    };
  }
}
