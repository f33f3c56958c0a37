// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Surfaces traced together: a scene of the kernels. */

#include "surface.h"

struct CbvhGroupTy : embree::beside::Counted
{
  CbvhGroupTy(CbvhContext context, const CbvhSurface* surfaces, size_t count);

  void commit();

  const embree::beside::Held<CbvhContextTy> context;
  const RTCScene scene;
  std::vector<embree::beside::Held<CbvhSurfaceTy>> surfaces;
  std::vector<size_t> firstPrimitive;   // first primitive of each surface, then the total
  CbvhStatistics statistics = CbvhStatistics(); // of the last commit
  bool isCommitted = false;
  void* userPtr = nullptr;

private:
  ~CbvhGroupTy() override;

  void keepStatistics();

  std::vector<RTCGeometry> attached;   // attached geometry of each surface
  size_t unsupportedFaces = 0;         // faces that the last commit left out
};
