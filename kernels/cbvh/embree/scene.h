// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's devices, scenes, geometries, subdivision patches, BVHs with allocators and builders, and tasks. */

#include "../../common/default.h"
#include "../../common/rtcore.h"
#include "../../common/device.h"
#include "../../common/scene.h"
#include "../../common/scene_subdiv_mesh.h"
#include "../../common/scene_grid_mesh.h"
#include "../../common/scene_triangle_mesh.h"
#include "../../common/scene_instance.h"
#include "../../common/accelinstance.h"
#include "../../../common/lexers/tokenstream.h"
#include "../../subdiv/patch_eval_grid.h"
#include "../../subdiv/subdivpatch1base.h"
#include "../../geometry/subdivpatch1.h"
#include "../../geometry/grid_soa.h"
#include "../../bvh/bvh.h"
#include "../../bvh/bvh_builder.h"
#include "../../builders/bvh_builder_sah.h"
