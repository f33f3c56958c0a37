// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A group: surfaces that are traced together, as a scene of the kernels. */

#include "surface.h"

struct CbvhGroupTy : embree::capi::RefCounted {
  CbvhGroupTy(CbvhContext context, const CbvhSurface* surfaces, size_t count);

  /* Builds the tree over the surfaces' last commits. If a surface is not committed, throws and leaves the group
   * unchanged. If input was left out, throws once, after the commit (see cbvhCommitGroup). */
  void commit();

  const embree::capi::RefPtr<CbvhContextTy> context;
  const RTCScene scene;
  std::vector<embree::capi::RefPtr<CbvhSurfaceTy>> surfaces;
  // index of each surface's first primitive in the group, then the count of all primitives; zeros before a commit
  std::vector<size_t> firstPrimitive;
  CbvhGroupStatistics statistics = CbvhGroupStatistics(); // of the last commit
  bool isCommitted = false;                               // false after a commit that failed
  bool wasCommitted = false;                              // true from the first commit that did not fail
  void* userPtr = nullptr;

private:
  ~CbvhGroupTy() override;

  void updateStatistics();

  std::vector<RTCGeometry> attached; // geometry that the scene contains for each surface, or NULL
  std::vector<bool> isReported;      // true if the faces that attached[i] leaves out were reported
};
