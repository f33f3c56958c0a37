// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's own grids, for what is not compressed. */

#include "../embree/scene.h"
#include "block_store.h"
#include "build_statistics.h"

namespace embree
{
  namespace isa
  {
    class GridWriter
    {
    public:
      /*! GRID cuts patches into grids of 8 x 8 quads */
      static const unsigned gridQuads = 8;

      GridWriter (Scene* scene, BlockStore& store, cbvh::BuildStatistics& statistics) : scene(scene), store(store), statistics(statistics) {}

      /*! patch as stock Embree has it */
      void write (const SubdivPatch1Base& patch) const
      {
        const unsigned x1 = patch.grid_u_res-1, y1 = patch.grid_v_res-1;
        for (unsigned y=0; y<y1; y+=gridQuads)
          for (unsigned x=0; x<x1; x+=gridQuads)
            write(patch,x,min(x+gridQuads,x1),y,min(y+gridQuads,y1));
      }

      void write (const SubdivPatch1Base& patch, unsigned x0, unsigned x1, unsigned y0, unsigned y1) const
      {
        BBox3fa bounds;
        GridSOA* soa = GridSOA::create(&patch,1,x0,x1,y0,y1,scene,store.allocator,&bounds);
        statistics.sums.gridBytes += offsetof(GridSOA,data) + soa->rootOffset + sizeof(BVH4::NodeRef);
        statistics.sums.numGridQuads += size_t(x1-x0)*size_t(y1-y0);
        store.add(bounds,size_t(BVH4::encodeTypedLeaf(soa,cbvh::GRID_SOA_ROOT)));
      }

    private:
      Scene* scene;
      BlockStore& store;
      cbvh::BuildStatistics& statistics;
    };
  }
}
