// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Limits and numbers that blocks, files and the kernels share. */

#ifndef CVERT_FORMAT_LIMITS_H
#define CVERT_FORMAT_LIMITS_H

#include "../portable/language.h"

CVERT_BEGIN

/*! Largest rate of an edge, and most quads per side of a cage's patch. As in Embree. */
CVERT_CONSTANT uint32_t maxVertRate = 4096u;

/*! Blocks begin at multiples of this, in bytes, in memory and in files. */
CVERT_CONSTANT uint32_t blockAlignment = 16u;

/*! Surface numbers identify the surface of a block. Without movingSurface, they start here in files; lower ones are of
 *  surfaces that this process built. */
CVERT_CONSTANT uint32_t firstFileNumber = 1u << 30;

/*! Bit of the number of a moving surface. */
CVERT_CONSTANT uint32_t movingSurface = 0x80000000u;

CVERT_END

#endif
