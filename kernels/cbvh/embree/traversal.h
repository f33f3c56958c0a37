// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's box and triangle tests, the leaves of GRID, its traversal of single rays, packets and streams, and its
 * epilogues, which report hits and call filters. One file is a .cpp, because it defines the members of a template. */

#include "ray.h"
#include "../../geometry/grid_soa.h"
#include "../../geometry/intersector_epilog.h"
#include "../../geometry/triangle_intersector_pluecker.h"
#include "../../bvh/node_intersector1.h"
#include "../../bvh/node_intersector_packet.h"
#include "../../bvh/node_intersector_frustum.h"
#include "../../bvh/bvh_intersector1.cpp"
#include "../../bvh/bvh_intersector_hybrid.h"
#include "../../bvh/bvh_intersector_stream.h"
