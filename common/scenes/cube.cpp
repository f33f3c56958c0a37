// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scenes/cube.h"

namespace programs {
namespace {

/* 3 x 3 spikes, flat at the borders of a face. */
class Spikes : public Displacement {
public:
  explicit Spikes(float height) : height(height) {}

  void offsets(const SurfacePoints& points, float* out) const override {
    for (size_t i = 0; i < points.n; i++) {
      const float s = wave(points.u[i]) * wave(points.v[i]);
      out[i] = height * s * s * s;
    }
  }

private:
  static float wave(float x) {
    const float s = std::sin(3.0f * float(M_PI) * x);
    return s * s;
  }

  float height;
};

} // namespace

Model makeCube(float amplitude) {
  Model model;
  model.name = "cube";
  model.cage.name = "cube";
  for (int i = 0; i < 8; i++)
    model.cage.positions.push_back({i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f});
  model.cage.faceSizes.assign(6, 4);
  /* Counterclockwise from outside; -x, +x, -y, +y, -z, +z. */
  model.cage.faceIndices = {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
  model.displacement = std::make_shared<Spikes>(amplitude * model.cage.bounds().diagonal());
  model.view.direction = {-0.55f, -0.45f, -0.8f};
  model.view.closePoint = {0.5f, 0.45f};
  model.view.closeDistance = 0.35f;
  return model;
}

} // namespace programs
