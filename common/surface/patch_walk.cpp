// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/patch_walk.h"

namespace programs {
namespace {

/* Edges counterclockwise: v = 0, u = 1, v = 1, u = 0. The inward normal of an edge is the direction of the next. */
constexpr double along[5][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 0}};

void pointOfEdge(unsigned edge, double t, PatchPoint& p) {
  p.u = edge == 0 ? t : edge == 1 ? 1.0 : edge == 2 ? 1.0 - t : 0.0;
  p.v = edge == 0 ? 0.0 : edge == 1 ? t : edge == 2 ? 1.0 : 1.0 - t;
}

/* Fraction of a step from x by dx that stays within [0,1]. */
double partInside(double x, double dx) {
  if (x + dx > 1.0) return std::max(0.0, (1.0 - x) / dx);
  if (x + dx < 0.0) return std::max(0.0, -x / dx);
  return 1.0;
}

} // namespace

PatchWalk::PatchWalk(const Cage& cage, const std::function<bool(unsigned)>& hasSurface) : borders(cage) {
  for (unsigned face = 0; face < cage.numFaces(); face++) exists.push_back(hasSurface(face));
}

PatchPoint PatchWalk::advance(PatchPoint p, double du, double dv) const {
  /* Exceeds the number of faces around a vertex. Near a corner a line may cross more borders: the rest is dropped. */
  constexpr int maxCrossings = 80;
  for (int i = 0; i < maxCrossings; i++) {
    const double s = partInside(p.u, du), t = partInside(p.v, dv), part = std::min(s, t);
    p.u = std::min(std::max(p.u + part * du, 0.0), 1.0);
    p.v = std::min(std::max(p.v + part * dv, 0.0), 1.0);
    if (part == 1.0) return p;
    du *= 1.0 - part;
    dv *= 1.0 - part;
    const unsigned edge = s < t ? (du > 0.0 ? 1 : 3) : (dv > 0.0 ? 2 : 0);
    const double where[4] = {p.u, p.v, 1.0 - p.u, 1.0 - p.v};
    const double tangent = du * along[edge][0] + dv * along[edge][1];
    const double inward = du * along[edge + 1][0] + dv * along[edge + 1][1];
    Crossing next;
    if (!crossEdge(p.face, p.subPatch, edge, where[edge], next)) {
      du = tangent * along[edge][0];
      dv = tangent * along[edge][1];
      continue;
    }
    p.face = next.face;
    p.subPatch = next.subPatch;
    pointOfEdge(next.edge, next.t, p);
    const double* const a = along[next.edge];
    const double* const n = along[next.edge + 1];
    du = -next.scale * (tangent * a[0] + inward * n[0]);
    dv = -next.scale * (tangent * a[1] + inward * n[1]);
  }
  return p;
}

/* Corner quad i of an n-gon: edge 0 is the first half of edge i, edge 3 the second half of the edge before corner i,
 * edge 1 is edge 2 of the next corner quad. */
bool PatchWalk::crossEdge(unsigned face, unsigned subPatch, unsigned edge, double t, Crossing& out) const {
  const unsigned n = borders.size(face);
  out.scale = 1.0;
  if (n != 4) {
    if (edge == 1 || edge == 2) {
      out = {face, (subPatch + (edge == 1 ? 1 : n - 1)) % n, 3 - edge, 1.0 - t, 1.0};
      return true;
    }
    t = 0.5 * t + (edge == 3 ? 0.5 : 0.0);
    edge = (subPatch + (edge == 3 ? n - 1 : 0)) % n;
    out.scale = 0.5;
  }
  const FaceBorders::Side side = borders.opposite(face, edge);
  if (side.face == ~0u || !exists[side.face]) return false;
  t = 1.0 - t;
  out.face = side.face;
  if (borders.size(side.face) == 4) {
    out.subPatch = 0;
    out.edge = side.edge;
    out.t = t;
    return true;
  }
  const bool first = t <= 0.5;
  out.subPatch = first ? side.edge : (side.edge + 1) % borders.size(side.face);
  out.edge = first ? 0 : 3;
  out.t = first ? 2.0 * t : 2.0 * t - 1.0;
  out.scale *= 2.0;
  return true;
}

PatchPoint PatchWalk::fromEmbree(const FacePoint& p) const {
  float u = p.u, v = p.v;
  unsigned subPatch = 0;
  if (borders.size(p.face) != 4) subPatch = std::min(decodeSubPatch(u, v), borders.size(p.face) - 1);
  return {p.face, subPatch, std::min(std::max(double(u), 0.0), 1.0), std::min(std::max(double(v), 0.0), 1.0)};
}

FacePoint PatchWalk::toEmbree(const PatchPoint& p) const {
  if (borders.size(p.face) == 4) return {p.face, float(p.u), float(p.v)};
  const Vec2f uv = encodeSubPatch(p.subPatch, float(p.u), float(p.v));
  return {p.face, uv.x, uv.y};
}

} // namespace programs
