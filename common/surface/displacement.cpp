// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/displacement.h"
#include "basics/progress.h"
#include "surface/mapped_texture.h"
#include "surface/seam_gaps.h"
#include "surface/vector_displacement.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace programs {
namespace {

class HeightDisplacement : public Displacement {
public:
  HeightDisplacement(std::unique_ptr<MappedTexture> texture, float scale, float midLevel)
    : texture(std::move(texture)),
      scale(scale),
      midLevel(midLevel) {}

  void offsets(const SurfacePoints& points, float* out) const override {
    const FaceBorders& borders = texture->borders();
    for (size_t i = 0; i < points.n; i++) {
      const FacePoint p{points.face, points.u[i], points.v[i]};
      float h = height(p, points.levelAt(i));
      const FaceBorders::BorderPosition at = borders.borderPosition(p);
      if (at.edge >= 0 && texture->isSeam(p.face, at)) {
        float least = h, most = h;
        h = borders.mean(p.face, at, h, [&](const FacePoint& q) {
          const float side = height(q, points.levelAt(i));
          least = std::min(least, side);
          most = std::max(most, side);
          return side;
        });
        if (points.gaps)
          points.gaps->add(std::abs(scale) * (most - least),
                           texture->edgeLength(p.face, at) * std::exp2(-points.levelAt(i)), p.face);
      }
      out[i] = scale * (h - midLevel);
    }
  }

  float texelsAlongEdge(unsigned face, unsigned edge) const override { return texture->texelsAlongEdge(face, edge); }

private:
  float height(const FacePoint& p, float level) const {
    float h = midLevel;
    texture->sample(p, level, &h);
    return h;
  }

  std::unique_ptr<MappedTexture> texture;
  float scale, midLevel;
};

} // namespace

float Displacement::texelsAlongEdge(unsigned, unsigned) const { return INFINITY; }

void Displacement::vectors(const SurfacePoints& points, const Vec3f* normals, Vec3f* vectors) const {
  std::vector<float> along(points.n);
  offsets(points, along.data());
  for (size_t i = 0; i < points.n; i++) vectors[i] = along[i] * normals[i];
}

float midLevelOf(const DisplacementMap& map) {
  return map.midLevel.value_or(map.values == MapValues::Heights ? neutralHeight : 0.0f);
}

std::unique_ptr<Displacement> displaceByMap(const Cage& cage, const DisplacementMap& map, std::string& warnings) {
  Phase phase("displacement map");
  std::unique_ptr<MappedTexture> texture = MappedTexture::create(cage, map, warnings);
  if (map.values == MapValues::Heights)
    return std::make_unique<HeightDisplacement>(std::move(texture), map.scale, midLevelOf(map));
  return displaceByVectors(cage, std::move(texture), map);
}

} // namespace programs
