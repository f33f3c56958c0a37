// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Macros of cvert/basics/language.h for headers of the kernels that are compiled as C++ and as GLSL. */

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
    /* overloads next to the functions for Embree's vectors */
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
