// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"

namespace embree
{
  /*! Marks the faces that Embree's patches cannot hold (isUnsupportedAtVertex), in each topology. Requires
   *  half-edges. */
  void markUnsupportedFaces (SubdivMesh* mesh);

  /*! Throw if a face does not exist, has no edges, or is marked: Embree would access memory past its patch. As
   *  thread-safe as rtcInterpolate. */
  void requireSupported (const SubdivMesh* mesh, const RTCInterpolateArguments* args);
  void requireSupported (const SubdivMesh* mesh, const RTCInterpolateNArguments* args);
}
