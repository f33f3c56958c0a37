// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The hierarchy of nodes of a glTF document. */

#include "basics/vec.h"
#include "meshes/gltf_value.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace programs {

/* Affine; column by column, the last one is the translation. */
struct GltfMatrix {
  std::array<Vec3d, 4> columns{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}, Vec3d{0, 0, 0}};

  Vec3d applyToVector(Vec3d v) const { return columns[0] * v.x + columns[1] * v.y + columns[2] * v.z; }
  Vec3d apply(Vec3d p) const { return applyToVector(p) + columns[3]; }

  friend GltfMatrix operator*(const GltfMatrix& a, const GltfMatrix& b) {
    GltfMatrix product;
    for (size_t i = 0; i < 3; i++) product.columns[i] = a.applyToVector(b.columns[i]);
    product.columns[3] = a.apply(b.columns[3]);
    return product;
  }

  /* True if it turns the inside of a surface outside. */
  bool isMirrored() const { return dot(cross(columns[0], columns[1]), columns[2]) < 0; }
};

/* Requires 16 numbers, column by column. */
GltfMatrix gltfMatrixOf(const double* numbers, const GltfValue& place);

struct GltfNodes {
  std::vector<GltfMatrix> toWorld;  // of all nodes
  std::vector<size_t> inSceneOrder; // nodes of the default scene, or of the first one; all if there are no scenes
};

/* Appends a line to `warnings` for scenes that are left out. Throws Error for nodes that are no trees. */
GltfNodes readGltfNodes(const GltfValue& document, const std::string& file, std::string& warnings);

} // namespace programs
