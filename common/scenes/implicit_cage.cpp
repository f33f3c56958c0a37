// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Based on: Inigo Quilez, "Distance functions" (round cone) and "Smooth minimum" (quadratic polynomial). */

#include "scenes/implicit_cage.h"

#include <cstdint>
#include <unordered_map>

namespace programs {
namespace {

float distanceToCapsule(const Capsule& c, Vec3f p) {
  const Vec3f ba = c.b - c.a;
  const float l2 = dot(ba, ba);
  const float rr = c.radiusA - c.radiusB;
  const float a2 = l2 - rr * rr;
  if (a2 <= 0.0f) // one ball inside the other
    return std::min(length(p - c.a) - c.radiusA, length(p - c.b) - c.radiusB);
  const float il2 = 1.0f / l2;
  const Vec3f pa = p - c.a;
  const float y = dot(pa, ba), z = y - l2;
  const Vec3f d = pa * l2 - ba * y;
  const float x2 = dot(d, d);
  const float y2 = y * y * l2, z2 = z * z * l2;
  const float k = (rr > 0 ? 1.0f : -1.0f) * rr * rr * x2;
  if ((z > 0 ? 1.0f : -1.0f) * a2 * z2 > k) return std::sqrt(x2 + z2) * il2 - c.radiusB;
  if ((y > 0 ? 1.0f : -1.0f) * a2 * y2 < k) return std::sqrt(x2 + y2) * il2 - c.radiusA;
  return (std::sqrt(x2 * a2 * il2) + y * rr) * il2 - c.radiusA;
}

class VoxelGrid {
public:
  VoxelGrid(const std::vector<Capsule>& capsules, const VoxelSize& voxelSize) {
    Box3f box;
    for (const Capsule& c : capsules)
      for (float sign : {-1.0f, 1.0f}) {
        box.extend(c.a + sign * c.radiusA * Vec3f{1, 1, 1});
        box.extend(c.b + sign * c.radiusB * Vec3f{1, 1, 1});
      }
    const float lower[3] = {box.lower.x, box.lower.y, box.lower.z}, upper[3] = {box.upper.x, box.upper.y, box.upper.z};
    for (int axis = 0; axis < 3; axis++) {
      /* Two empty layers, so that filling never reaches the border. */
      float x = lower[axis] - 2.0f * voxelSize(axis, lower[axis]);
      for (; x < upper[axis] + 2.0f * voxelSize(axis, upper[axis]); x += voxelSize(axis, x)) lines[axis].push_back(x);
      lines[axis].push_back(x);
    }
    nx = int(lines[0].size()) - 1;
    ny = int(lines[1].size()) - 1;
    nz = int(lines[2].size()) - 1;
    inside.resize(size_t(nx) * ny * nz);
    for (int z = 0; z < nz; z++)
      for (int y = 0; y < ny; y++)
        for (int x = 0; x < nx; x++)
          at(x, y, z) = distanceToCapsules(capsules, 0.5f * (corner(x, y, z) + corner(x + 1, y + 1, z + 1))) < 0.0f;
  }

  uint8_t& at(int x, int y, int z) { return inside[(size_t(z) * ny + y) * nx + x]; }
  Vec3f corner(int x, int y, int z) const { return {lines[0][size_t(x)], lines[1][size_t(y)], lines[2][size_t(z)]}; }

  /* Adds a voxel where two full or two empty ones share only an edge or a corner. Terminates, because voxels are only
   * added. */
  void makeManifold() {
    for (bool changed = true; changed;) {
      changed = false;
      for (int z = 0; z + 1 < nz; z++)
        for (int y = 0; y + 1 < ny; y++)
          for (int x = 0; x + 1 < nx; x++) changed |= repair(x, y, z);
    }
  }

  int nx, ny, nz;

private:
  bool repair(int x, int y, int z) {
    /* The corner's 2 x 2 squares in the three planes. */
    auto diagonal = [&](int ax, int ay, int az, int bx, int by, int bz) {
      uint8_t &p = at(x, y, z), &q = at(x + ax + bx, y + ay + by, z + az + bz);
      uint8_t &r = at(x + ax, y + ay, z + az), &s = at(x + bx, y + by, z + bz);
      if (p && q && !r && !s) return r = 1, true;
      if (r && s && !p && !q) return p = 1, true;
      return false;
    };
    if (diagonal(1, 0, 0, 0, 1, 0) || diagonal(1, 0, 0, 0, 0, 1) || diagonal(0, 1, 0, 0, 0, 1)) return true;
    /* Opposite voxels of the 2 x 2 x 2 cube share only the corner if the other six are of the other kind. */
    int full = 0;
    for (int i = 0; i < 8; i++) full += at(x + (i & 1), y + ((i >> 1) & 1), z + (i >> 2));
    for (int i = 0; i < 4; i++) {
      uint8_t& p = at(x + (i & 1), y + ((i >> 1) & 1), z + (i >> 2));
      uint8_t& q = at(x + 1 - (i & 1), y + 1 - ((i >> 1) & 1), z + 1 - (i >> 2));
      if ((full == 6 && !p && !q) || (full == 2 && p && q))
        return (full == 6 ? p : at(x + 1 - (i & 1), y + ((i >> 1) & 1), z + (i >> 2))) = 1, true;
    }
    return false;
  }

  std::vector<float> lines[3]; // boundaries of voxels on each axis
  std::vector<uint8_t> inside;
};

Cage voxelSurface(VoxelGrid& grid) {
  Cage cage;
  std::unordered_map<uint64_t, unsigned> vertexOf;
  auto vertex = [&](int x, int y, int z) {
    const uint64_t key = (uint64_t(z) * (grid.ny + 1) + y) * (grid.nx + 1) + x;
    const auto [found, fresh] = vertexOf.try_emplace(key, unsigned(cage.positions.size()));
    if (fresh) cage.positions.push_back(grid.corner(x, y, z));
    return found->second;
  };
  /* A quad between a full and an empty voxel, counterclockwise as seen from the empty one. */
  for (int z = 0; z + 1 < grid.nz; z++)
    for (int y = 0; y + 1 < grid.ny; y++)
      for (int x = 0; x + 1 < grid.nx; x++)
        for (int axis = 0; axis < 3; axis++) {
          const int dx = axis == 0, dy = axis == 1, dz = axis == 2;
          const bool here = grid.at(x, y, z), ahead = grid.at(x + dx, y + dy, z + dz);
          if (here == ahead) continue;
          const int bx = x + dx, by = y + dy, bz = z + dz;
          /* Unit steps of the other axes, in cyclic order. */
          const int ux = axis == 2, uy = axis == 0, uz = axis == 1;
          const int vx = axis == 1, vy = axis == 2, vz = axis == 0;
          unsigned q[4] = {vertex(bx, by, bz), vertex(bx + ux, by + uy, bz + uz),
                           vertex(bx + ux + vx, by + uy + vy, bz + uz + vz), vertex(bx + vx, by + vy, bz + vz)};
          if (ahead) std::swap(q[1], q[3]);
          cage.faceIndices.insert(cage.faceIndices.end(), q, q + 4);
          cage.faceSizes.push_back(4);
        }
  return cage;
}

void relax(Cage& cage, const std::vector<Capsule>& capsules, const VoxelSize& voxelSize) {
  constexpr int iterations = 10;
  for (int iteration = 0; iteration < iterations; iteration++) {
    std::vector<Vec3f> sum(cage.positions.size());
    std::vector<float> count(cage.positions.size());
    for (size_t f = 0; f < cage.numFaces(); f++) {
      const unsigned* q = &cage.faceIndices[4 * f];
      const Vec3f center =
          0.25f * (cage.positions[q[0]] + cage.positions[q[1]] + cage.positions[q[2]] + cage.positions[q[3]]);
      for (int i = 0; i < 4; i++) {
        sum[q[i]] += center;
        count[q[i]] += 1.0f;
      }
    }
    for (size_t i = 0; i < cage.positions.size(); i++) {
      const Vec3f at = cage.positions[i];
      const float voxel = std::min({voxelSize(0, at.x), voxelSize(1, at.y), voxelSize(2, at.z)}), h = 0.01f * voxel;
      Vec3f p = lerp(cage.positions[i], sum[i] * (1.0f / count[i]), 0.6f);
      const float d = distanceToCapsules(capsules, p);
      const auto slope = [&](Vec3f d) {
        return distanceToCapsules(capsules, p + d) - distanceToCapsules(capsules, p - d);
      };
      const Vec3f gradient{slope({h, 0, 0}), slope({0, h, 0}), slope({0, 0, h})};
      const float step = std::min(std::max(d, -0.5f * voxel), 0.5f * voxel);
      cage.positions[i] = p - step * normalize(gradient);
    }
  }
}

} // namespace

float distanceToCapsules(const std::vector<Capsule>& capsules, Vec3f p) {
  float d = INFINITY;
  for (const Capsule& c : capsules) {
    const float e = distanceToCapsule(c, p), other = c.carve ? -e : e;
    const float h = c.smooth > 0.0f ? std::max(c.smooth - std::abs(d - other), 0.0f) / c.smooth : 0.0f;
    d = c.carve ? std::max(d, -e) + 0.25f * h * h * c.smooth : std::min(d, e) - 0.25f * h * h * c.smooth;
  }
  return d;
}

Cage makeImplicitCage(const std::vector<Capsule>& capsules, const VoxelSize& voxelSize) {
  VoxelGrid grid(capsules, voxelSize);
  grid.makeManifold();
  Cage cage = voxelSurface(grid);
  relax(cage, capsules, voxelSize);
  return cage;
}

} // namespace programs
