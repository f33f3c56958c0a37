// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Makes the names of the codec (kernels/cvert) visible in embree::cbvh. CBVH_ISA is the inline namespace of the
 * instruction set that a file is compiled for. CBVH_BEGIN and CBVH_END enclose code that compiles as C++ and as GLSL.
 * See cvert/portable/language.h. */

#ifndef CBVH_BASE_CODEC_NAMES_H
#define CBVH_BASE_CODEC_NAMES_H

#include "../../cvert/portable/language.h"

#ifdef VULKAN
#define CBVH_BEGIN
#define CBVH_END
#else
#define CBVH_ISA CVERT_ISA
// clang-format off
#define CBVH_BEGIN namespace embree { namespace cbvh { inline namespace CBVH_ISA {
#define CBVH_END }}}
// clang-format on

namespace embree::cbvh {
using namespace cvert;

/* The overloads in namespace embree (vectors.h) would hide names that only the using-directive makes visible,
 * because it acts like declarations in the global namespace. */
using cvert::minimum;
using cvert::maximum;
using cvert::magnitude;
using cvert::choose;
using cvert::product;
} // namespace embree::cbvh
#endif

#endif
