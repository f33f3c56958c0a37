// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"

namespace embree
{
  /*! Marks the faces of a cage that Embree's patches cannot hold, in each topology: faces at a vertex that is
   *  unsupported (isUnsupportedAtVertex). To be called after the half-edges were made. */
  void markUnsupportedFaces (SubdivMesh* mesh);

  /*! Throw if a face that is to be interpolated does not exist, has no edges, or was marked: Embree would read and
   *  write past its patch. Thread safety: as rtcInterpolate. */
  void requireSupported (const SubdivMesh* mesh, const RTCInterpolateArguments* args);
  void requireSupported (const SubdivMesh* mesh, const RTCInterpolateNArguments* args);
}
