// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's point queries, and queries of ours that take the same way through a scene's trees. */

#include "../../common/context.h"
#include "../../common/point_query.h"
#include "../../common/scene.h"
