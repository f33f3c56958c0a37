// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Makes the names of the codec, kernels/cvert, visible in embree::cbvh. Inline code of the kernels is also compiled
 * once per ISA, in the namespace CBVH_ISA. CBVH_BEGIN and CBVH_END are for headers that are compiled as C++ and as
 * GLSL, as in cvert/basics/language.h. */

#ifndef CBVH_CODEC_H
#define CBVH_CODEC_H

#include "../../cvert/basics/language.h"

#ifdef VULKAN
#define CBVH_BEGIN
#define CBVH_END
#else
#define CBVH_ISA CVERT_ISA
#define CBVH_BEGIN namespace embree { namespace cbvh { inline namespace CBVH_ISA {
#define CBVH_END }}}

namespace embree
{
  namespace cbvh
  {
    using namespace cvert;

    /* overloads next to the functions for Embree's vectors */
    using cvert::lesser;
    using cvert::greater;
    using cvert::magnitude;
    using cvert::choose;
    using cvert::product;
  }
}
#endif

#endif
