// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks the arguments of rtcInterpolate and rtcInterpolateN for subdivision surfaces. Embree does not check them. */

#include "../embree/scene.h"

namespace embree
{
  /*! Marks the faces whose neighborhood exceeds the fixed-size arrays of Embree's patches, in each topology. Requires
   *  half-edges. */
  void markUnsupportedFaces (SubdivMesh* mesh);

  /*! Throw rtcore_error if a face does not exist, has no edges or is marked, or if (u,v) is in none of its sub-patches:
   *  Embree would read past its arrays. As thread-safe as rtcInterpolate. */
  void requireSupported (const SubdivMesh* mesh, const RTCInterpolateArguments* args);
  void requireSupported (const SubdivMesh* mesh, const RTCInterpolateNArguments* args);
}
