// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The codec's language, cvert/basics/language.h, for headers of the kernels that are C++ and GLSL, too. */

#ifndef CBVH_LANGUAGE_H
#define CBVH_LANGUAGE_H

#include "../../cvert/basics/language.h"

#ifdef VULKAN
#define CBVH_BEGIN
#define CBVH_END
#else
#include "codec.h"

namespace embree
{
  namespace cbvh
  {
    /* Found next to the functions of the same names for Embree's vectors. */
    using cvert::lesser;
    using cvert::greater;
    using cvert::magnitude;
    using cvert::choose;
    using cvert::product;
  }
}

#define CBVH_BEGIN namespace embree { namespace cbvh { inline namespace CBVH_ISA {
#define CBVH_END }}}
#endif

#endif
