// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"

namespace embree
{
  /*! Throws if a face of a cage refers to indices or vertices that do not exist: Embree would read them. */
  void checkIndices (const SubdivMesh* mesh);
}
