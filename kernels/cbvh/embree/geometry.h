// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's base class of geometries, for headers that Embree's own scene headers include (state/). They cannot include
 * scene.h. */

#include "../../common/geometry.h"
