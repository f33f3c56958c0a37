// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Tangents as in MikkTSpace: one per face corner, the mean over all faces with the same vertex and texture
 * coordinate, interpolated over the face and made perpendicular to the normal. So on an edge they depend on the edge
 * alone, unlike derivatives of the limit surface. */

#include "surface/vector_displacement.h"
#include "basics/error.h"
#include "surface/seam_gaps.h"

#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>

namespace programs {
namespace {

/* The texture's second axis is to the left of the first one, seen from outside, or to the right if mirrored. */
struct Tangents {
  std::vector<Vec3f> corners;
  std::vector<float> sides; // per face: left 1, right -1
};

Tangents findTangents(const Cage& cage, const FaceBorders& borders) {
  Tangents tangents;
  tangents.corners.resize(cage.faceIndices.size());
  std::map<std::tuple<unsigned, float, float, float>, Vec3f> sums; // vertex, coordinate, side
  const auto position = [&](size_t c) { return cage.positions[cage.faceIndices[c]]; };
  const auto uv = [&](size_t c) { return cage.uvs[cage.uvIndices[c]]; };
  const auto key = [&](unsigned face, size_t c) {
    return std::make_tuple(cage.faceIndices[c], uv(c).x, uv(c).y, tangents.sides[face]);
  };
  for (unsigned face = 0; face < cage.numFaces(); face++) {
    const unsigned n = cage.faceSizes[face];
    float area = 0; // twice the face's area in texture coordinates
    for (unsigned i = 0; i < n; i++) {
      const Vec2f a = uv(borders.corner(face, i)), b = uv(borders.corner(face, (i + 1) % n));
      area += a.x * b.y - b.x * a.y;
    }
    tangents.sides.push_back(area < 0.0f ? -1.0f : 1.0f);
    for (unsigned i = 0; i < n; i++) {
      const size_t c = borders.corner(face, i), next = borders.corner(face, (i + 1) % n),
                   last = borders.corner(face, (i + n - 1) % n);
      const Vec3f e1 = position(next) - position(c), e2 = position(last) - position(c);
      const Vec2f d1 = uv(next) - uv(c), d2 = uv(last) - uv(c);
      Vec3f& sum = sums[key(face, c)];
      sum += normalize(tangents.sides[face] * (d2.y * e1 - d1.y * e2));
    }
  }
  for (unsigned face = 0; face < cage.numFaces(); face++)
    for (unsigned i = 0; i < cage.faceSizes[face]; i++) {
      const size_t c = borders.corner(face, i);
      tangents.corners[c] = normalize(sums[key(face, c)]);
    }
  return tangents;
}

class VectorDisplacement : public Displacement {
public:
  VectorDisplacement(const Cage& cage, std::unique_ptr<MappedTexture> mapped, const DisplacementMap& description)
    : texture(std::move(mapped)),
      scale(description.scale),
      midLevel(midLevelOf(description)) {
    if (description.values == MapValues::TangentVectors) tangents = findTangents(cage, texture->borders());
  }

  bool isAlongNormals() const override { return false; }

  void offsets(const SurfacePoints&, float*) const override {
    throw std::logic_error("a displacement by vectors has no offsets along normals");
  }

  void vectors(const SurfacePoints& points, const Vec3f* normals, Vec3f* out) const override {
    const FaceBorders& borders = texture->borders();
    for (size_t i = 0; i < points.n; i++) {
      const FacePoint p{points.face, points.u[i], points.v[i]};
      const auto vectorAt = [&](const FacePoint& q) { return vector(q, points.levelAt(i), normals[i]); };
      out[i] = vectorAt(p);
      const FaceBorders::BorderPosition at = borders.borderPosition(p);
      if (at.edge < 0) continue;
      Box3f sides;
      sides.extend(out[i]);
      out[i] = borders.mean(p.face, at, out[i], [&](const FacePoint& q) {
        const Vec3f side = vectorAt(q);
        sides.extend(side);
        return side;
      });
      if (points.gaps && texture->isSeam(p.face, at))
        points.gaps->add(sides.diagonal(), texture->edgeLength(p.face, at) * std::exp2(-points.levelAt(i)), p.face);
    }
  }

  float texelsAlongEdge(unsigned face, unsigned edge) const override { return texture->texelsAlongEdge(face, edge); }

private:
  Vec3f vector(const FacePoint& p, float level, Vec3f normal) const {
    float v[3] = {midLevel, midLevel, midLevel};
    texture->sample(p, level, v);
    for (float& x : v) x = scale * (x - midLevel);
    if (tangents.corners.empty()) return {v[0], v[1], v[2]};
    const FaceBorders& borders = texture->borders();
    const Vec3f along = interpolate(&tangents.corners[borders.corner(p.face, 0)], borders.size(p.face), p);
    const Vec3f tangent = normalize(along - dot(along, normal) * normal);
    return v[0] * tangent + v[1] * normal + (tangents.sides[p.face] * v[2]) * cross(normal, tangent);
  }

  std::unique_ptr<MappedTexture> texture;
  float scale, midLevel;
  Tangents tangents; // empty for vectors along the cage's axes
};

} // namespace

std::unique_ptr<Displacement> displaceByVectors(const Cage& cage, std::unique_ptr<MappedTexture> texture,
                                                const DisplacementMap& description) {
  if (description.values == MapValues::TangentVectors && !cage.hasUVs())
    throw Error(cage.name + ": vectors in tangent space need texture coordinates, but the cage has none");
  return std::make_unique<VectorDisplacement>(cage, std::move(texture), description);
}

} // namespace programs
