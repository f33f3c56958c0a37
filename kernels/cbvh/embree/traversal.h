// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's box and triangle tests, the leaves of GRID and their intersectors, traversal of single rays, packets and
 * streams, and epilogues, which report hits and call filters. */

#include "simd.h"
#include "../../common/ray.h"
#include "../../geometry/grid_soa.h"
#include "../../geometry/intersector_epilog.h"
#include "../../geometry/triangle_intersector_pluecker.h"
#include "../../bvh/node_intersector1.h"
#include "../../bvh/node_intersector_packet.h"
#include "../../bvh/node_intersector_frustum.h"
#include "../../geometry/subdivpatch1_intersector.h"
#include "../../bvh/bvh_traverser1.h"
#include "../../bvh/bvh_intersector_hybrid.h"
#include "../../bvh/bvh_intersector_stream.h"
