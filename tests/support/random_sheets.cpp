// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "support/random_sheets.h"

#include <algorithm>

namespace programs::test {

const char* nameOf(Shape shape) {
  static const char* const names[] = {"waves",    "noise", "spikes", "jumps",     "folded",          "saddle",
                                      "vertical", "flat",  "needle", "trapezoid", "collapsed quads", "collapsed side"};
  return names[int(shape)];
}

const char* nameOf(RayKind kind) {
  static const char* const names[] = {
      "across",        "along an axis",          "through a vertex",      "across an edge",
      "along an edge", "in the plane of a leaf", "from inside the block", "from inside a leaf",
      "segment"};
  return names[int(kind)];
}

Sheet randomSheet(Random& random, Shape shape, unsigned height, const Placement& at) {
  Sheet sheet;
  sheet.shape = shape;
  sheet.quads = 1u << height;
  sheet.scale = at.scale;
  const unsigned n = sheet.quads;
  double corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}; // in the order of the face
  for (auto& c : corners)
    for (int k = 0; k < 3; k++) c[k] += 0.1 * random.normal();
  switch (shape) {
  case Shape::Needle:
    for (auto& c : corners) c[1] *= 1e-3;
    break;
  case Shape::Flat:
    for (auto& c : corners) c[2] = 0;
    break;
  case Shape::Trapezoid:
    corners[2][0] = 0.7;
    corners[3][0] = 0.3;
    break;
  case Shape::Folded: std::swap(corners[2], corners[3]); break;
  case Shape::Saddle:
    for (int c = 0; c < 4; c++) corners[c][2] = c & 1 ? 0.4 : -0.4;
    break;
  case Shape::CollapsedSide: std::copy_n(corners[2], 3, corners[3]); break;
  default: break;
  }
  const double phase = 6 * random.uniform();
  auto toWorld = [&](const double p[3]) {
    return Vec{float(at.position[0] + at.scale * p[0]), float(at.position[1] + at.scale * p[1]),
               float(at.position[2] + at.scale * p[2])};
  };
  for (unsigned y = 0; y <= n; y++)
    for (unsigned x = 0; x <= n; x++) {
      const double u = double(x) / n, v = double(y) / n;
      double p[3];
      for (int k = 0; k < 3; k++)
        p[k] =
            (1 - v) * ((1 - u) * corners[0][k] + u * corners[1][k]) + v * ((1 - u) * corners[3][k] + u * corners[2][k]);
      switch (shape) {
      case Shape::Waves:
      case Shape::Folded:
      case Shape::Trapezoid:
      case Shape::CollapsedQuads:
      case Shape::CollapsedSide: p[2] += 0.05 * std::sin(7 * u + 3 * v + phase); break;
      case Shape::Noise:
        for (double& c : p) c += 0.2 / n * random.normal();
        break;
      case Shape::Spikes:
        if (random.chance(0.1)) p[2] += 0.5 * random.uniform();
        break;
      case Shape::Jumps: p[2] += (x > n / 3) != (y > n / 2) ? 0.3 : 0; break;
      case Shape::Needle: p[2] += 1e-3 * random.normal(); break;
      case Shape::Vertical:
        p[2] += 2 * u;
        p[0] *= 0.01;
        break;
      default: break;
      }
      sheet.vertices.push_back(toWorld(p));
    }
  if (shape == Shape::CollapsedQuads && n > 1) // quads that degenerate to lines, triangles and points
    for (unsigned i = 0; i < n * n / 2 + 1; i++) {
      const unsigned x = 1 + random.below(n - 1), y = 1 + random.below(n - 1);
      sheet.vertices[y * (n + 1) + x] = sheet.vertex(x - random.below(2), y - random.below(2));
    }
  for (auto& c : corners) sheet.cage.positions.push_back(toWorld(c));
  sheet.cage.addFace({0, 1, 2, 3});
  sheet.cage.mode = RTC_SUBDIVISION_MODE_PIN_ALL;
  return sheet;
}

// Replaces the vertices of the tessellator.
static void place(const RTCDisplacementFunctionNArguments* args) {
  const Sheet& sheet = *(const Sheet*)args->geometryUserPtr;
  for (unsigned i = 0; i < args->N; i++) {
    const Vec& p =
        sheet.vertex(unsigned(std::lround(args->u[i] * sheet.quads)), unsigned(std::lround(args->v[i] * sheet.quads)));
    args->P_x[i] = p[0];
    args->P_y[i] = p[1];
    args->P_z[i] = p[2];
  }
}

void commitSheet(RTCDevice device, RTCScene scene, const Sheet& sheet, RTCCompression compression) {
  SurfaceSettings settings;
  settings.rate = float(sheet.quads);
  settings.compression = compression;
  settings.frameLevel = 0;
  RTCGeometry geometry = newSurface(device, sheet.cage, settings);
  rtcSetGeometryUserData(geometry, (void*)&sheet);
  rtcSetGeometryDisplacementFunction(geometry, place);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
}

RTCRayHit randomRay(Random& random, RayKind kind, const Sheet& sheet, double directionLength) {
  const unsigned x = random.below(sheet.quads), y = random.below(sheet.quads);
  const Vec corner[3] = {sheet.vertex(x, y), sheet.vertex(x + 1, y), sheet.vertex(x, y + 1)};
  double target[3], dir[3];
  double a = random.uniform(), b = random.uniform() * (1 - a);
  if (kind == RayKind::ThroughVertex) a = b = 0;
  if (kind == RayKind::AcrossEdge || kind == RayKind::AlongEdge) b = 0;
  for (int k = 0; k < 3; k++) {
    dir[k] = random.normal();
    target[k] = corner[0][k] + a * (double(corner[1][k]) - corner[0][k]) + b * (double(corner[2][k]) - corner[0][k]);
  }
  if (kind == RayKind::AlongAxis) {
    const int axis = int(random.below(3));
    for (int k = 0; k < 3; k++) dir[k] = k == axis ? (random.chance(0.5) ? 1 : -1) : 0;
  }
  if (kind == RayKind::AlongEdge || kind == RayKind::InPlaneOfLeaf)
    for (int k = 0; k < 3; k++) dir[k] = double(corner[1][k]) - corner[0][k];
  if (kind == RayKind::Across)
    for (double& t : target) t += 0.1 * sheet.scale * random.normal();
  double length = std::sqrt(dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2]);
  if (!(length > 0)) { dir[2] = length = 1; }
  double back = 3 * sheet.scale; // distance from the origin to the target
  if (kind == RayKind::FromInsideBlock) back = 0.2 * sheet.scale * random.uniform();
  if (kind == RayKind::FromInsideLeaf) back = random.chance(0.5) ? 0 : 0.01 * sheet.scale * random.uniform();
  Vec o, d;
  for (int k = 0; k < 3; k++) {
    o[k] = float(target[k] - back * dir[k] / length);
    d[k] = float(dir[k] / length * directionLength);
  }
  const float unit = float(sheet.scale / directionLength);
  RTCRayHit ray = makeRay(o, d);
  if (kind == RayKind::Segment) {
    ray.ray.tnear = unit * float(random.uniform(0, 3.2));
    ray.ray.tfar = unit * float(random.uniform(2.8, 6));
  }
  if (kind == RayKind::FromInsideLeaf) ray.ray.tnear = unit * 1e-4f;
  return ray;
}

} // namespace programs::test
