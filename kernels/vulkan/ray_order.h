// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Sizes of the radix sort of rays, shared by shaders/ray_order.comp and host/ray_order.cpp. */

#ifndef CBVH_VULKAN_RAY_ORDER_H
#define CBVH_VULKAN_RAY_ORDER_H

#include "../cbvh/base/codec_names.h"

CBVH_BEGIN

CVERT_CONSTANT uint32_t orderThreads = 256u; //!< threads per workgroup
CVERT_CONSTANT uint32_t orderKeysPerThread = 16u;
CVERT_CONSTANT uint32_t orderTileSize =
    orderThreads * orderKeysPerThread;       //!< keys per workgroup that counts or scatters
CVERT_CONSTANT uint32_t orderDigitBits = 4u; //!< bits that a pass sorts by
CVERT_CONSTANT uint32_t orderRadix = 16u;    //!< values of a digit, 2^orderDigitBits
CVERT_CONSTANT uint32_t orderPasses = 8u;    //!< for keys of 30 bits; even, so that the result is in the first
                                             //!< of two buffers

CBVH_END

#endif
