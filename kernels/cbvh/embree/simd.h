// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's platform, instruction sets and vector types.
 *
 * Only this folder includes Embree's internal headers. Ports to other versions of Embree start here. */

#include "../../common/isa.h"
#include "../../../common/sys/platform.h"
#include "../../../common/math/constants.h"
#include "../../../common/simd/simd.h"
