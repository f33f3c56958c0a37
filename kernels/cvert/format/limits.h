// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Limits of patches, blocks and the numbers of surfaces. */

#ifndef CVERT_LIMITS_H
#define CVERT_LIMITS_H

#include "../basics/language.h"

CVERT_BEGIN

/*! largest rate of an edge, and largest number of quads along a side of a patch */
CVERT_CONSTANT uint32_t maxVertRate = 4096u;

/*! blocks in memory and in files begin at multiples of this */
CVERT_CONSTANT uint32_t blockAlignment = 16u;

/*! In files, the numbers of surfaces start here. Lower ones are for surfaces in memory. */
CVERT_CONSTANT uint32_t firstFileNumber = 1u << 30;

/*! added to the number of a surface that moves */
CVERT_CONSTANT uint32_t movingSurface = 0x80000000u;

CVERT_END

#endif
