// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A displaced subdivision surface, copies of one, or a mesh without subdivision. */

#include "surface/cage.h"
#include "surface/displacement.h"
#include "surface/view_hints.h"

#include <memory>
#include <string>
#include <vector>

namespace programs {

/* The copy is scaled, rotated about the y axis, then moved. */
struct Placement {
  Vec3f origin;
  float angle = 0; // radians
  float scale = 1;

  Vec3f apply(Vec3f p) const {
    const float c = std::cos(angle), s = std::sin(angle);
    return origin + scale * Vec3f{c * p.x + s * p.z, p.y, c * p.z - s * p.x};
  }

  /* Displacements scale with the copy; normals do not. */
  Vec3f vectorFromCage(Vec3f v) const { return Placement{{}, angle, scale}.apply(v); }
  Vec3f normalToCage(Vec3f n) const {
    const float c = std::cos(angle), s = std::sin(angle);
    return {c * n.x - s * n.z, n.y, s * n.x + c * n.z};
  }

  /* Inverses; directions keep their length. */
  Vec3d pointToCage(Vec3d p) const { return directionToCage(p - toDouble(origin)) * (1.0 / scale); }
  Vec3d directionToCage(Vec3d d) const {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * d.x - s * d.z, d.y, s * d.x + c * d.z};
  }
};

struct Model {
  std::string name;
  Cage cage; // of a mesh: faces of 4 vertices, triangles repeat the last one

  /* Vertices at the time steps after the first, at equal intervals. */
  std::vector<std::vector<Vec3f>> poses;

  bool isMesh = false;
  float spacing = 0; // of a lattice that contains a mesh's vertices, or 0
  std::shared_ptr<const Displacement> displacement;
  std::vector<Placement> copies{Placement()}; // geometries, not instances

  /* Vertices of each copy before it is placed; empty if all have the cage's. */
  std::vector<std::vector<Vec3f>> shapes;

  ViewHints view;
  std::string up = "y"; // assumed by view, see up_axis.h
  bool isUpGuessed = false;

  size_t numFaces() const { return cage.numFaces() * copies.size(); }
  size_t numVertices() const { return cage.positions.size() * copies.size(); }
  PatchLayout layout(int level) const { return PatchLayout(cage, isMesh ? 0 : level, copies.size()); }

  const std::vector<Vec3f>* shapeOf(size_t copy) const { return shapes.empty() ? nullptr : &shapes[copy]; }

  /* A vertex of a copy with its own shape moves as the cage's vertex, which is at p in this pose. */
  static Vec3f positionInShape(Vec3f p, const std::vector<Vec3f>* shape, const Cage& cage, size_t vertex) {
    return shape ? (*shape)[vertex] + (p - cage.positions[vertex]) : p;
  }

  std::vector<Vec3f> positions() const {
    std::vector<Vec3f> all;
    all.reserve(numVertices() * (1 + poses.size()));
    for (size_t i = 0; i < copies.size(); i++)
      for (size_t step = 0; step <= poses.size(); step++) {
        const std::vector<Vec3f>& pose = step ? poses[step - 1] : cage.positions;
        for (size_t vertex = 0; vertex < pose.size(); vertex++)
          all.push_back(copies[i].apply(positionInShape(pose[vertex], shapeOf(i), cage, vertex)));
      }
    return all;
  }
};

} // namespace programs
