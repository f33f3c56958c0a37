// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Fits frames: one 3D projective map per block, from world space to the block's box [0,1]^3, aligned to the block's
 * corners.
 *
 *    world           frame               p -> (X,Y,Z,W), linear in p
 *      ______         ______             x = X/W, y = Y/W, z = Z/W
 *     /      \       |      |
 *    /        \  ->  |      |            A trapezoid becomes a square, a straight
 *   /__________\     |______|            line stays straight.
 *
 * In the plane of the corners, the map is the homography from the corner quad to the unit square. Along the normal, W
 * is constant and Z is the signed distance. The vertices are scaled to fill [0,1]^3, so the root needs no bounds.
 *
 * The map is stored relative to "center", the world point of (1/2,1/2,1/2), where W = 1: 3 + 12 floats. Vertices and
 * ray origins are first made relative to the center, so that no precision is lost far from the origin.
 *
 * Affine fallback. A homography is used only if
 *
 * - the corners, seen along the normal, form a convex quad without a corner triangle below 1/64 of the quad's area;
 * - W, over all vertices, is positive and stays within maxWRatio: z is stretched by 1/W, and the error of the ray
 *   parameter in floats grows with the ratio;
 * - W, at the eight corners of the box, is positive and within a factor of 2 maxWRatio of the center's: the box is then
 *   a bounded region of the world, and a ray's part in it is a segment with finite ends.
 *
 * Otherwise the axes are the mean edges, or orthogonal if these are nearly parallel. Affine frames fit less tightly.
 *
 * Based on: Heckbert, "Fundamentals of Texture Mapping and Image Warping", 1989 (square to quad); Selgrad et al. 2016,
 * Lier et al. 2018 (use for patches). */

#include "frame_map.h"
#include <cfloat>

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! Largest ratio of W at two vertices of a block. */
static constexpr double maxWRatio = 4.0;

/*! Distance of the vertices from the faces of the frame's box, to which maps are scaled. After a map is rounded to
 *  floats, at least half of it remains: twice containmentSlack (node.h). */
static constexpr double frameMargin = 1.0 / (1 << 18);

/*! Assumed bound of the distance between two faces' evaluations of a shared vertex, relative to the largest
 *  absolute coordinate. Each takes about twenty float operations. Bounds are widened by this distance, so that the
 *  bounds of neighboring blocks overlap. */
static constexpr double vertexRounding = 2.0 / (1 << 23);

/*! Smallest extent of a box relative to its largest: keeps maps of flat blocks and needles invertible. If this
 *  widens x or y, the frame is "degenerate": leaves would be wider than their quads. */
static constexpr double minExtentRatio = 1.0 / (1 << 14);

/*! Orthonormal axes: e1 and e2 in the plane of the corners, n along its normal. */
struct CornerPlane {
  Double3 e1, e2, n;
};

/*! Returns a unit vector orthogonal to `a`. */
inline Double3 anyOrthogonal(const Double3& a) {
  const Double3 axis = std::fabs(a.x) < std::fabs(a.y)
                           ? (std::fabs(a.x) < std::fabs(a.z) ? Double3{1, 0, 0} : Double3{0, 0, 1})
                           : (std::fabs(a.y) < std::fabs(a.z) ? Double3{0, 1, 0} : Double3{0, 0, 1});
  const Double3 c = cross(a, axis);
  return (1.0 / length(c)) * c;
}

/*! Axes of the mean plane of four corners, in the order (0,0), (1,0), (0,1), (1,1). e1 has the direction
 *  of the mean edge along x, unless that edge has no length. */
inline CornerPlane fitPlane(const Double3 p[4]) {
  const Double3 d1 = p[3] - p[0], d2 = p[2] - p[1];
  const Double3 a = (p[1] - p[0]) + (p[3] - p[2]);
  const Double3 b = (p[2] - p[0]) + (p[3] - p[1]);
  CornerPlane plane;
  plane.n = cross(d1, d2);
  const double ln = length(plane.n), la = length(a), lb = length(b);
  const Double3 longest = la >= lb ? a : b;
  const double ll = length(longest);
  if (ln > 1e-9 * length(d1) * length(d2) && ln > 0) plane.n = (1.0 / ln) * plane.n;
  else // collapsed corners
    plane.n = ll > 0 ? anyOrthogonal((1.0 / ll) * longest) : Double3{0, 0, 1};
  Double3 e1 = a - dot(a, plane.n) * plane.n;
  if (!(length(e1) > 1e-9 * ll)) e1 = cross(b, plane.n);
  plane.e1 = length(e1) > 0 ? (1.0 / length(e1)) * e1 : anyOrthogonal(plane.n);
  plane.e2 = cross(plane.n, plane.e1);
  return plane;
}

/*! Sets `map` to the homography of the corners. Returns false if they form no convex quad, see above.
 *  Based on: Heckbert 1989. */
inline bool fitProjective(const Double3 p[4], const CornerPlane& plane, FrameMap& map) {
  double a[4], b[4];
  for (int i = 0; i < 4; i++) {
    a[i] = dot(p[i], plane.e1);
    b[i] = dot(p[i], plane.e2);
  }

  /* Convexity: each corner triangle needs a positive share of the area. The four triangles cover the quad twice. */
  const int ring[4] = {0, 1, 3, 2};
  double twiceArea = 0, smallest = DBL_MAX;
  for (int i = 0; i < 4; i++) {
    const int i0 = ring[(i + 3) & 3], i1 = ring[i], i2 = ring[(i + 1) & 3];
    const double t = (a[i1] - a[i0]) * (b[i2] - b[i0]) - (a[i2] - a[i0]) * (b[i1] - b[i0]);
    twiceArea += 0.5 * t;
    smallest = t < smallest ? t : smallest;
  }
  if (!(twiceArea > 0) || !(smallest > twiceArea / 64)) return false;

  /* Square to quad: a = (sa x + ta y + a0)/(g x + h y + 1), and the same for b. */
  const double dx1 = a[1] - a[3], dx2 = a[2] - a[3], dx3 = a[0] - a[1] + a[3] - a[2];
  const double dy1 = b[1] - b[3], dy2 = b[2] - b[3], dy3 = b[0] - b[1] + b[3] - b[2];
  const double den = dx1 * dy2 - dx2 * dy1;
  if (!(std::fabs(den) > 0)) return false;
  const double g = (dx3 * dy2 - dx2 * dy3) / den;
  const double h = (dx1 * dy3 - dx3 * dy1) / den;
  const double m[3][3] = {{a[1] - a[0] + g * a[1], a[2] - a[0] + h * a[2], a[0]},
                          {b[1] - b[0] + g * b[1], b[2] - b[0] + h * b[2], b[0]},
                          {g, h, 1}};
  /* Quad to square: the inverse, as adjugate divided by determinant. */
  double q[3][3];
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++)
      q[c][r] = m[(r + 1) % 3][(c + 1) % 3] * m[(r + 2) % 3][(c + 2) % 3] -
                m[(r + 1) % 3][(c + 2) % 3] * m[(r + 2) % 3][(c + 1) % 3];
  const double det = m[0][0] * q[0][0] + m[0][1] * q[1][0] + m[0][2] * q[2][0];
  if (!(std::fabs(det) > 0)) return false;

  auto form = [&](int r) { return LinearForm{(q[r][0] / det) * plane.e1 + (q[r][1] / det) * plane.e2, q[r][2] / det}; };
  map.X = form(0);
  map.Y = form(1);
  map.W = form(2);
  map.Z =
      LinearForm{plane.n, -0.25 * (dot(p[0], plane.n) + dot(p[1], plane.n) + dot(p[2], plane.n) + dot(p[3], plane.n))};
  map.projective = true;
  return true;
}

/*! Sets `map` to the affine map of the parallelogram of the mean edges, or of a square if these are nearly
 *  parallel. */
inline void fitAffine(const Double3 p[4], const CornerPlane& plane, FrameMap& map) {
  const Double3 a = 0.5 * ((p[1] - p[0]) + (p[3] - p[2]));
  const Double3 b = 0.5 * ((p[2] - p[0]) + (p[3] - p[1]));
  double m00 = dot(a, plane.e1), m01 = dot(b, plane.e1);
  double m10 = dot(a, plane.e2), m11 = dot(b, plane.e2);
  const double det = m00 * m11 - m01 * m10;
  const double size = maximum(length(a), length(b));
  if (!(det > 1e-3 * length(a) * length(b))) {
    m00 = m11 = size > 0 ? size : 1.0;
    m01 = m10 = 0;
  }
  const double r = 1.0 / (m00 * m11 - m01 * m10);
  map.X = LinearForm{(r * m11) * plane.e1 + (-r * m01) * plane.e2, 0};
  map.Y = LinearForm{(-r * m10) * plane.e1 + (r * m00) * plane.e2, 0};
  map.Z = LinearForm{plane.n, 0};
  map.W = LinearForm{{0, 0, 0}, 1};
  map.projective = false;
}

/*! Returns false if rounding made the axes of a sliver linearly dependent. */
inline bool isInvertible(const Frame& frame) {
  Double3 row[3];
  for (int k = 0; k < 3; k++) row[k] = {frame.columns[0][k], frame.columns[1][k], frame.columns[2][k]};
  return std::fabs(dot(row[0], cross(row[1], row[2]))) > 1e-6 * length(row[0]) * length(row[1]) * length(row[2]);
}

/*! X, Y, Z and W, one per lane. */
struct MapLanes {
  Double4 x, y, z, d;

  explicit MapLanes(const FrameMap& m)
    : x(m.X.n.x, m.Y.n.x, m.Z.n.x, m.W.n.x),
      y(m.X.n.y, m.Y.n.y, m.Z.n.y, m.W.n.y),
      z(m.X.n.z, m.Y.n.z, m.Z.n.z, m.W.n.z),
      d(m.X.d, m.Y.d, m.Z.d, m.W.d) {}

  Double4 operator()(const Double3& p) const { return x * p.x + y * p.y + z * p.z + d; }
};

/*! Bounds of the vertices after a map. */
struct MappedVertices {
  double lower[4], upper[4]; //!< of x, y and z; require isWBounded()
  double minW, maxW;         //!< minW is -1 unless W is positive at all vertices
  double worldExtent;        //!< upper bound, on the longest axis

  /*! vertices: at least one. farthest: their largest absolute coordinate, relative to the map's origin. */
  MappedVertices(const FrameMap& map, const Double3* vertices, size_t count, double farthest)
    : worldExtent(2 * farthest) {
    const MapLanes lanes(map);
    Double4 least = DBL_MAX, most = -DBL_MAX, low = DBL_MAX, high = -DBL_MAX;
    uint32_t positive = ~0u;
    for (size_t i = 0; i < count; i++) {
      const Double4 h = lanes(vertices[i]), l = h / broadcast<3>(h);
      positive &= (Double4(0.0) < h).bits();
      least = min(h, least);
      most = max(h, most);
      low = min(l, low);
      high = max(l, high);
    }
    double w[2][4];
    least.store(w[0]);
    most.store(w[1]);
    minW = positive & 8 ? w[0][3] : -1;
    maxW = w[1][3];
    low.store(lower);
    high.store(upper);
  }

  bool isWBounded() const { return minW > 0 && maxW <= maxWRatio * minW; }
};

/*! Scales X, Y and Z so that the vertices fill the box. First widens their bounds by vertexRounding as if W were
 *  constant, and each extent to at least minExtentRatio of the block's world-space size and the resolution of
 *  floats. Returns true if x or y was smaller than that (Frame::degenerate). origin: world position to which the
 *  map's points are relative. vertices: receives the widened bounds. */
inline bool fillBox(FrameMap& map, const Double3& origin, MappedVertices& vertices) {
  const double coordinate =
      maximum(std::fabs(origin.x), maximum(std::fabs(origin.y), std::fabs(origin.z))) + vertices.worldExtent;
  const double w0 = map.W({0, 0, 0}) > 0 ? map.W({0, 0, 0}) : vertices.maxW;
  const double minSize =
      maximum(maximum(minExtentRatio * vertices.worldExtent, coordinate * std::ldexp(1.0, -22)), 1e-30);
  LinearForm* forms[3] = {&map.X, &map.Y, &map.Z};
  bool degenerate = false;
  for (int k = 0; k < 3; k++) {
    const double minExtent = minSize * length(forms[k]->n) / w0, extent = vertices.upper[k] - vertices.lower[k];
    const double grow = maximum(vertexRounding * coordinate * norm1(forms[k]->n) / w0, 0.5 * (minExtent - extent));
    if (k < 2 && minExtent > extent) degenerate = true;
    vertices.lower[k] -= grow;
    vertices.upper[k] += grow;
    const double s = (1 - 2 * frameMargin) / (vertices.upper[k] - vertices.lower[k]);
    *forms[k] = s * (*forms[k]) + (frameMargin - s * vertices.lower[k]) * map.W;
  }
  return degenerate;
}

/*! True if W is positive and bounded at the eight corners of the box. center: of the box, relative to the map's
 *  origin. */
inline bool isWBoundedInBox(const FrameMap& map, const Double3& center) {
  if (!map.projective) return true;
  for (int i = 0; i < 8; i++) {
    Double3 q;
    if (!unproject(map, i & 1, (i >> 1) & 1, i >> 2, q)) return false;
    const double w = map.W(q) / map.W(center);
    if (!(w > 1.0 / (2 * maxWRatio) && w < 2 * maxWRatio)) return false;
  }
  return true;
}

/*! Sets `distance` to the vertices' largest distance from the box's center on each axis. Returns false if W is not
 *  positive or a distance is not finite. center: relative to the vertices' origin. */
inline bool centerDistances(const Frame& frame, const Double3& center, const Double3* vertices, size_t count,
                            double distance[3]) {
  const FrameLanes lanes(frame.columns);
  Double4 farthest = 0.0;
  uint32_t positive = ~0u;
  for (size_t i = 0; i < count; i++) {
    const Double4 h = lanes(vertices[i] - center);
    positive &= (Double4(0.0) < h).bits();
    farthest = max(abs(h / broadcast<3>(h) - 0.5), farthest);
  }
  double far[4];
  farthest.store(far);
  for (int k = 0; k < 3; k++) distance[k] = far[k];
  return positive & 8 && std::isfinite(distance[0]) && std::isfinite(distance[1]) && std::isfinite(distance[2]);
}

/*! Sets frame.columns to a map, rounded to floats. Blocks do not store the map's constants: frames map the rounded
 *  center to exactly (1/2,1/2,1/2), which shifts vertices. The map is therefore scaled about the center, and
 *  rounded anew, until the box contains every vertex with half of frameMargin. Returns false if this fails.
 *  Requires frame.center. */
inline bool roundMap(const FrameMap& map, const Double3& origin, const Double3* vertices, size_t count, Frame& frame) {
  const Double3 rounded = {double(frame.center[0]) - origin.x, double(frame.center[1]) - origin.y,
                           double(frame.center[2]) - origin.z};
  const double w = map.W(rounded);
  if (!(w > 0)) return false;
  Double3 rows[4] = {(1 / w) * map.X.n, (1 / w) * map.Y.n, (1 / w) * map.Z.n, (1 / w) * map.W.n};
  for (int attempt = 0; attempt < 8; attempt++) {
    for (int k = 0; k < 4; k++) {
      frame.columns[0][k] = float(rows[k].x);
      frame.columns[1][k] = float(rows[k].y);
      frame.columns[2][k] = float(rows[k].z);
    }
    double distance[3];
    if (!centerDistances(frame, rounded, vertices, count, distance)) return false;
    bool inside = true;
    for (int k = 0; k < 3; k++) {
      if (distance[k] <= 0.5 - 0.5 * frameMargin) continue;
      inside = false;
      /* x - 1/2 = (X - W/2)/W: scales the numerator. */
      const double s = (0.5 - frameMargin) / distance[k];
      rows[k] = s * rows[k] + (0.5 * (1 - s)) * rows[3];
    }
    if (inside) return isInvertible(frame);
  }
  return false;
}

/*! Scales a map so that the box contains the vertices, and sets `frame`. Returns false if W is out of bounds or
 *  floats cannot represent the map. vertices: relative to origin. farthest: see MappedVertices. */
inline bool fitBox(FrameMap map, const Double3& origin, const Double3* vertices, size_t count, double farthest,
                   Frame& frame) {
  MappedVertices mapped(map, vertices, count, farthest);
  if (!mapped.isWBounded()) return false;
  frame.degenerate = fillBox(map, origin, mapped);
  frame.projective = map.projective;

  Double3 center;
  if (!unproject(map, 0.5, 0.5, 0.5, center) || !isWBoundedInBox(map, center)) return false;
  frame.center[0] = float(origin.x + center.x);
  frame.center[1] = float(origin.y + center.y);
  frame.center[2] = float(origin.z + center.z);
  return roundMap(map, origin, vertices, count, frame);
}

/*! Sets `frame` to the frame of a block. If its vertices have no extent, the box has the size of the resolution of
 *  floats there. Returns false if floats cannot represent any frame; no finite vertices are known for which this
 *  happens. corners: finite world positions to align to, in the order (0,0), (1,0), (0,1), (1,1). vertices: `count`
 *  finite world positions to contain, at least one. scratch: memory for `count` points. */
inline bool fitFrame(const float corners[4][3], const float (*vertices)[3], size_t count, Double3* scratch,
                     Frame& frame) {
  const Double3 origin = {0.5 * (double(corners[0][0]) + double(corners[3][0])),
                          0.5 * (double(corners[0][1]) + double(corners[3][1])),
                          0.5 * (double(corners[0][2]) + double(corners[3][2]))};
  auto relative = [&](const float p[3]) { return Double3{p[0] - origin.x, p[1] - origin.y, p[2] - origin.z}; };
  Double3 p[4];
  for (int i = 0; i < 4; i++) p[i] = relative(corners[i]);
  const Double4 from(origin.x, origin.y, origin.z, 0.0);
  Double4 distance = 0.0;
  for (size_t i = 0; i < count; i++) {
    const Double4 d = Double4(loadVertex(vertices, i, count)) - from;
    distance = max(distance, abs(d));
    if (i + 1 < count) d.store(&scratch[i].x); // also writes the next point's first coordinate
    else scratch[i] = relative(vertices[i]);
  }
  double far[4];
  distance.store(far);
  const double farthest = maximum(far[0], maximum(far[1], far[2]));

  const CornerPlane plane = fitPlane(p);
  FrameMap map;
  if (fitProjective(p, plane, map) && fitBox(map, origin, scratch, count, farthest, frame)) return true;
  fitAffine(p, plane, map);
  if (fitBox(map, origin, scratch, count, farthest, frame)) return true;

  /* a square in the same plane */
  map.X = LinearForm{plane.e1, 0};
  map.Y = LinearForm{plane.e2, 0};
  map.Z = LinearForm{plane.n, 0};
  return fitBox(map, origin, scratch, count, farthest, frame);
}
}} // namespace embree::cbvh::CBVH_ISA
