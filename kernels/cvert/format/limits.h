// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0


#ifndef CVERT_LIMITS_H
#define CVERT_LIMITS_H

#include "../basics/language.h"

CVERT_BEGIN

/*! Largest rate of an edge, and most quads per side of a patch. */
CVERT_CONSTANT uint32_t maxVertRate = 4096u;

/*! In memory and in files, in bytes. */
CVERT_CONSTANT uint32_t blockAlignment = 16u;

/*! Surface numbers in files start here; lower ones are for surfaces in memory. */
CVERT_CONSTANT uint32_t firstFileNumber = 1u << 30;

/*! Added to the number of a moving surface. */
CVERT_CONSTANT uint32_t movingSurface = 0x80000000u;

CVERT_END

#endif
