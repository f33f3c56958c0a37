// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

namespace embree
{
  namespace cbvh
  {
    /*! where a block is at a time step; empty if it has no finite vertex there */
    struct StepBox
    {
      float lower[3], upper[3];
      bool isEmpty () const { return !(lower[0] <= upper[0]); }
    };
  }
}
