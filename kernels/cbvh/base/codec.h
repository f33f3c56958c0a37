// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The codec, kernels/cvert, as the kernels see it: its names are visible in embree::cbvh. The kernels' own inline code is compiled once for
 * each ISA, too, in the namespace CBVH_ISA. */

#include "../../cvert/basics/isa_namespace.h"

#define CBVH_ISA CVERT_ISA

namespace cvert { inline namespace CVERT_ISA {} }

namespace embree
{
  namespace cbvh { using namespace cvert; }
}
