// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's point queries. */

#include "../../common/context.h"
#include "../../common/point_query.h"
#include "../../common/scene.h"
