// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Sizes of the sort of rays, shaders/ray_order.comp. */

#ifndef CBVH_RAY_ORDER_H
#define CBVH_RAY_ORDER_H

#include "../cbvh/base/language.h"

CBVH_BEGIN

CVERT_CONSTANT uint32_t orderThreads = 256u;                   //!< of a workgroup
CVERT_CONSTANT uint32_t orderKeys = 16u;                       //!< of a thread
CVERT_CONSTANT uint32_t orderTile = orderThreads*orderKeys;    //!< of a workgroup
CVERT_CONSTANT uint32_t orderDigitBits = 4u;
CVERT_CONSTANT uint32_t orderDigits = 16u;
CVERT_CONSTANT uint32_t orderPasses = 8u;                      //!< keys have 30 bits; an even number ends where it began

CBVH_END

#endif
