// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The door to Embree: the headers of this folder alone include what is Embree's own and not its API, so that they are what
 * another version of Embree changes. This one: the platform, instruction sets, and vectors of lanes. */

#include "../../common/isa.h"
#include "../../../common/sys/platform.h"
#include "../../../common/math/constants.h"
#include "../../../common/simd/simd.h"
