// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's platform, instruction sets and vector types.
 *
 * Only the headers in this folder include Embree's internal headers. A port to another version of Embree changes this
 * folder first. */

#include "../../common/isa.h"
#include "../../../common/sys/platform.h"
#include "../../../common/math/constants.h"
#include "../../../common/simd/simd.h"
