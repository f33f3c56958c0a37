// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Limits of patches, blocks and surface numbers. */

#ifndef CVERT_LIMITS_H
#define CVERT_LIMITS_H

#include "../basics/language.h"

CVERT_BEGIN

/*! Largest rate of an edge, and largest number of quads per side of a patch. */
CVERT_CONSTANT uint32_t maxVertRate = 4096u;

/*! Blocks in memory and in files begin at multiples of this many bytes. */
CVERT_CONSTANT uint32_t blockAlignment = 16u;

/*! Lowest surface number in files. Lower numbers are for surfaces in memory. */
CVERT_CONSTANT uint32_t firstFileNumber = 1u << 30;

/*! Added to the number of a moving surface. */
CVERT_CONSTANT uint32_t movingSurface = 0x80000000u;

CVERT_END

#endif
