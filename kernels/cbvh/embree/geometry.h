// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's geometries, for headers that Embree's scene headers include. */

#include "../../common/geometry.h"
