// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Reciprocals of ray directions, for tests against boxes on CPUs and GPUs. */

#ifndef CVERT_RULE_RECIPROCAL_H
#define CVERT_RULE_RECIPROCAL_H

#include "../portable/language.h"

CVERT_BEGIN

/*! Reciprocal of component d of a direction. largest: magnitude of the largest component. Both must be finite. Clamps
 *  the magnitude of d to at least 1e-18 * largest, which is far below the precision of floats. Also clamps it to the
 *  range from 2^-126, the smallest normal float, to 2^125. The result is therefore normal and not 0, and its product
 *  with any distance, also 0 or infinity, is not NaN. It is positive for both zeros: callers must select the near
 *  planes of boxes by its sign, not by the sign bit of d. */
CVERT_REAL CVERT_INLINE Real directionReciprocal(Real d, Real largest) {
  Real least = maximum(Real(1e-18f) * largest, Real(1.17549435e-38f));
  Real size = minimum(maximum(magnitude(d), least), Real(4.25352959e37f));
  return Real(1.0f) / choose(d < Real(0.0f), -size, size);
}

CVERT_END

#endif
