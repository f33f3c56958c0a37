// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"
#include <set>

namespace embree
{
  /*! Returns the bytes of the buffers that Embree allocated for a geometry and that the geometry still has, and of its
   *  half-edges. counted: buffers that were counted before, which are not counted again. */
  size_t bytesOfInput (const CompressibleGeometry* geometry, std::set<const void*>& counted);
}
