// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's rays and ray packets. */

#include "simd.h"
#include "../../common/ray.h"
