// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/traversal.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! Runs a point query over a tree of compressed geometries. bvh: a CompressedTree. Returns true if a call of the
       *  application's function changed the query. */
      bool queryPoint (const BVH4* bvh, PointQuery* query, PointQueryContext* context);
    }
  }
}
