// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Makes the names of the codec, kernels/cvert, visible in embree::cbvh. Inline code of the kernels is also compiled
 * once per ISA, in the namespace CBVH_ISA. */

#include "../../cvert/basics/isa_namespace.h"

#define CBVH_ISA CVERT_ISA

namespace cvert { inline namespace CVERT_ISA {} }

namespace embree
{
  namespace cbvh { using namespace cvert; }
}
