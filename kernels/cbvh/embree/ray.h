// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays, single and in packets, hits, and the context of a query. */

#include "simd.h"
#include "../../common/ray.h"
