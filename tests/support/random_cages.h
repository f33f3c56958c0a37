// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "support/random.h"
#include "surface/true_surface.h"

namespace programs::test {

/* (n+1)^2 control points over [0,n]^2. */
inline Cage sheet(unsigned n) {
  Cage cage;
  cage.name = "sheet";
  for (unsigned y = 0; y <= n; y++)
    for (unsigned x = 0; x <= n; x++) cage.positions.push_back({float(x), float(y), 0});
  for (unsigned y = 0; y < n; y++)
    for (unsigned x = 0; x < n; x++) {
      const unsigned i = y * (n + 1) + x;
      cage.faceSizes.push_back(4);
      cage.faceIndices.insert(cage.faceIndices.end(), {i, i + 1, i + n + 2, i + n + 1});
    }
  return cage;
}

/* Closed: two caps of n vertices, n quads. */
inline Cage prism(unsigned n) {
  Cage cage;
  cage.name = "prism";
  for (unsigned k = 0; k < 2; k++)
    for (unsigned i = 0; i < n; i++) {
      const double a = 2 * M_PI * i / n;
      cage.positions.push_back({float(std::cos(a)), float(std::sin(a)), k ? 0.8f : -0.8f});
    }
  cage.faceSizes = {n, n};
  for (unsigned i = 0; i < n; i++) cage.faceIndices.push_back(n - 1 - i);
  for (unsigned i = 0; i < n; i++) cage.faceIndices.push_back(n + i);
  for (unsigned i = 0; i < n; i++) {
    cage.faceSizes.push_back(4);
    cage.faceIndices.insert(cage.faceIndices.end(), {i, (i + 1) % n, n + (i + 1) % n, n + i});
  }
  return cage;
}

/* Closed: 2n quads; the last two vertices have valence n. */
inline Cage trapezohedron(unsigned n) {
  Cage cage;
  cage.name = "trapezohedron";
  for (unsigned i = 0; i < 2 * n; i++) {
    const double a = M_PI * i / n;
    cage.positions.push_back({float(std::cos(a)), float(std::sin(a)), i & 1 ? -0.3f : 0.3f});
  }
  cage.positions.push_back({0, 0, 1});
  cage.positions.push_back({0, 0, -1});
  cage.faceSizes.assign(2 * n, 4);
  for (unsigned i = 0; i < n; i++) {
    const unsigned a = 2 * i, b = 2 * i + 1, c = (2 * i + 2) % (2 * n), d = (2 * i + 3) % (2 * n);
    cage.faceIndices.insert(cage.faceIndices.end(), {2 * n, a, b, c, 2 * n + 1, d, c, b});
  }
  return cage;
}

inline Cage moved(Cage cage, Random& random, double size) {
  for (Vec3f& p : cage.positions)
    p += Vec3f{float(random.uniform(-size, size)), float(random.uniform(-size, size)),
               float(random.uniform(-size, size))};
  return cage;
}

inline Model modelOf(const Cage& cage) {
  Model model;
  model.name = cage.name;
  model.cage = cage;
  return model;
}

inline PatchPoint randomPoint(const Cage& cage, const TrueSurface& surface, Random& random) {
  unsigned face;
  do face = random.below(unsigned(cage.numFaces()));
  while (!surface.has(face));
  const unsigned size = cage.faceSizes[face];
  return {face, size == 4 ? 0 : random.below(size), random.uniform(), random.uniform()};
}

} // namespace programs::test
