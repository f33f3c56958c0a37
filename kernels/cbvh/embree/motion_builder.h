// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's BVH builder for motion blur. */

#include "scene.h"
#include "../../builders/bvh_builder_msmblur.h"
