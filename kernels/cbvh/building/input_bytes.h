// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"
#include <set>

namespace embree
{
  /*! Bytes of the buffers that Embree allocated for a geometry, and of the topology that Embree makes from them.
   *  counted: buffers to skip; receives this geometry's buffers. */
  size_t bytesOfInput (const CompressibleGeometry* geometry, std::set<const void*>& counted);
}
