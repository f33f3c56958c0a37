// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Geometries, for headers that those of scenes include. */

#include "../../common/geometry.h"
