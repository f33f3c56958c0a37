// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Random blocks of difficult shapes as displaced faces with given vertices, and random rays of difficult kinds at them.
 * */

#include "support/random.h"
#include "support/scene.h"

namespace programs::test {

enum class Shape {
  Waves,
  Noise,
  Spikes,
  Jumps,
  Folded,
  Saddle,
  Vertical,
  Flat,
  Needle,
  Trapezoid,
  CollapsedQuads,
  CollapsedSide
};
const std::vector<Shape> allShapes = {Shape::Waves,  Shape::Noise,     Shape::Spikes,         Shape::Jumps,
                                      Shape::Folded, Shape::Saddle,    Shape::Vertical,       Shape::Flat,
                                      Shape::Needle, Shape::Trapezoid, Shape::CollapsedQuads, Shape::CollapsedSide};
const char* nameOf(Shape);

struct Placement {
  double scale, position[3];
};

// One face of 2^height x 2^height quads.
struct Sheet {
  Shape shape;
  unsigned quads;
  double scale;
  Cage cage;                 // its corners, in the order of the face
  std::vector<Vec> vertices; // (quads+1)^2, row by row

  const Vec& vertex(unsigned x, unsigned y) const { return vertices[y * (quads + 1) + x]; }
};
Sheet randomSheet(Random& random, Shape shape, unsigned height, const Placement& at);

// Commits the sheet at frame level 0, or as GRID for RTC_COMPRESSION_NONE. `sheet` must outlive the scene.
void commitSheet(RTCDevice device, RTCScene scene, const Sheet& sheet, RTCCompression compression);

enum class RayKind {
  Across,
  AlongAxis,
  ThroughVertex,
  AcrossEdge,
  AlongEdge,
  InPlaneOfLeaf,
  FromInsideBlock,
  FromInsideLeaf,
  Segment
};
const std::vector<RayKind> allRays = {RayKind::Across,          RayKind::AlongAxis,      RayKind::ThroughVertex,
                                      RayKind::AcrossEdge,      RayKind::AlongEdge,      RayKind::InPlaneOfLeaf,
                                      RayKind::FromInsideBlock, RayKind::FromInsideLeaf, RayKind::Segment};
const char* nameOf(RayKind);

// directionLength: length of the ray's direction, the unit of t.
RTCRayHit randomRay(Random& random, RayKind kind, const Sheet& sheet, double directionLength = 1);

} // namespace programs::test
