// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"

namespace embree
{
  /*! Marks the faces that Embree's patches cannot hold, in each topology (isUnsupportedAtVertex). Call it after the
   *  half-edges were made. */
  void markUnsupportedFaces (SubdivMesh* mesh);

  /*! Throw if a face does not exist, has no edges, or was marked: Embree would access memory past its patch. Thread
   *  safety: as rtcInterpolate. */
  void requireSupported (const SubdivMesh* mesh, const RTCInterpolateArguments* args);
  void requireSupported (const SubdivMesh* mesh, const RTCInterpolateNArguments* args);
}
