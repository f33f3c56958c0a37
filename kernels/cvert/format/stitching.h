// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* How Embree stitches the border of a patch whose quads are more than the rate of an edge: several vertices of the
 * border lie on one vertex of the edge. */

#ifndef CVERT_STITCHING_H
#define CVERT_STITCHING_H

#include "../basics/language.h"

CVERT_BEGIN

/*! The vertex of an edge of that rate on which vertex x of a border of that many quads lies. The rate is at most
 *  maxVertRate, so that the product has 32 bits, or it is the number of quads: then vertices are not moved. */
CVERT_FUNCTION uint32_t stitchedVertex (uint32_t x, uint32_t quads, uint32_t rate) { return rate == quads ? x : (2u*x + 1u)*rate/(2u*quads); }

CVERT_END

#endif
