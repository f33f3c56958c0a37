// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Limits and numbers that blocks, files and the kernels share. */

#ifndef CVERT_LIMITS_H
#define CVERT_LIMITS_H

#include "../basics/language.h"

CVERT_BEGIN

/*! Largest rate of an edge (segments into which it is divided), and most quads per side of a patch. As in Embree. */
CVERT_CONSTANT uint32_t maxVertRate = 4096u;

/*! Blocks begin at multiples of this, in bytes, in memory and in files. */
CVERT_CONSTANT uint32_t blockAlignment = 16u;

/*! A surface number identifies the surface that a block belongs to. Numbers in files start here; lower ones are for
 *  surfaces that were built in this process. */
CVERT_CONSTANT uint32_t firstFileNumber = 1u << 30;

/*! Bit of the number of a moving surface. */
CVERT_CONSTANT uint32_t movingSurface = 0x80000000u;

CVERT_END

#endif
