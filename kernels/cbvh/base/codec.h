// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Makes the names of kernels/cvert visible in embree::cbvh. CBVH_ISA is the namespace of inline code, which is compiled
 * once per ISA. CBVH_BEGIN and CBVH_END enclose headers that are C++ and GLSL (cvert/basics/language.h). */

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

    /* The overloads in namespace embree (vectors.h) would hide names that only the using-directive makes visible. */
    using cvert::lesser;
    using cvert::greater;
    using cvert::magnitude;
    using cvert::choose;
    using cvert::product;
  }
}
#endif

#endif
