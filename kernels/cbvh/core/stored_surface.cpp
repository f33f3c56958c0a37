// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "stored_surface.h"
#include "../stored/required_blocks.h"
#include "../stored/stored_clusters.h"

namespace embree
{
  namespace core
  {
    namespace
    {
      /*! From AVX2 on, intersectors fuse multiply-adds, which changes vertices between time steps. */
      cbvh::TraversalTime traversalTime (Geometry* geometry, float time) {
        return cbvh::TraversalTime{ time,(geometry->device->enabled_cpu_features & AVX2) == AVX2 };
      }

      /*! References a geometry and its blocks, because callbacks may release or commit it. Throws without blocks. */
      struct HeldBlocks
      {
        const Ref<Geometry> geometry; // released last: blocks refer to its device
        const std::shared_ptr<const SurfaceBlocks> blocks;

        explicit HeldBlocks (Geometry* held)
          : geometry(held), blocks(asCompressible(held) ? cbvh::blocksOf(asCompressible(held)) : nullptr) {
          if (!blocks) throwNotCompressed();
        }
      };
    }

    float firstTime (Geometry* geometry) { return geometry->time_range.lower; }

    bool findTriangle (Geometry* geometry, float time, unsigned primID, float u, float v, const float* Ng,
        cbvh::StoredTriangle& triangle) {
      return requireBlocks(geometry).index().find(traversalTime(geometry,time),primID,u,v,Ng,triangle);
    }

    void forEachPart (Geometry* geometry, float time, const std::function<bool(const cbvh::StoredPart&)>& closure) {
      const HeldBlocks held(geometry);
      cbvh::forEachPart(*held.blocks,traversalTime(geometry,time),
          [&](const cbvh::StoredBlock&, const cbvh::StoredPart& part) { return closure(part); });
    }

    void forEachCluster (Geometry* geometry, float time, cbvh::ClusterFormat format,
        const std::function<bool(const cbvh::StoredCluster&)>& closure,
                         cbvh::ClusterStatistics& statistics)
    {
      statistics = cbvh::ClusterStatistics();
      const HeldBlocks held(geometry);
      if (format != cbvh::ClusterFormat::FLOAT3 && format != cbvh::ClusterFormat::COMPRESSED1
          && format != cbvh::ClusterFormat::DGF1)
        throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                       "unknown cluster format " + std::to_string(int(format)));
      cbvh::forEachCluster(*held.blocks,traversalTime(geometry,time),format,closure,statistics);
    }
  }
}
