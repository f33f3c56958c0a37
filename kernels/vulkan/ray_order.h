// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Sizes of the radix sort of rays (shaders/ray_order.comp). */

#ifndef CBVH_RAY_ORDER_H
#define CBVH_RAY_ORDER_H

#include "../cbvh/base/codec.h"

CBVH_BEGIN

CVERT_CONSTANT uint32_t orderThreads = 256u;                   //!< threads per workgroup
CVERT_CONSTANT uint32_t orderKeys = 16u;                       //!< keys per thread
CVERT_CONSTANT uint32_t orderTile = orderThreads*orderKeys;    //!< keys per workgroup
CVERT_CONSTANT uint32_t orderDigitBits = 4u;
CVERT_CONSTANT uint32_t orderDigits = 16u;
CVERT_CONSTANT uint32_t orderPasses = 8u;                      //!< 30 bits; even: the first buffer has the result

CBVH_END

#endif
