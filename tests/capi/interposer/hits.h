// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Hits of a program that runs twice. A first run without the interposer stores its hits in a file; a second run with it
 * must have the same hits except for the rounding to the lattice. */

#include "../host.h"

#include <algorithm>
#include <utility>

namespace stored_hits {

using host::Vec;

struct Kept {
  unsigned geomID, primID, instID, instPrimID;
  float t, u, v;
  Vec Ng;
};

class Hits {
public:
  explicit Hits(const char* path) : path(path) {
    if (FILE* const file = std::fopen(path, "rb")) {
      Kept kept;
      while (std::fread(&kept, sizeof(kept), 1, file) == 1) before.push_back(kept);
      std::fclose(file);
    }
  }

  void keep(const RTCRayHit& ray) {
    Vec Ng = {ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z};
    const float length = std::sqrt(Ng[0] * Ng[0] + Ng[1] * Ng[1] + Ng[2] * Ng[2]);
    for (float& x : Ng) x = length > 0 ? x / length : 0;
    const Kept kept = host::isHit(ray) ? Kept{ray.hit.geomID, ray.hit.primID, ray.hit.instID[0], ray.hit.instPrimID[0],
                                              ray.ray.tfar,   ray.hit.u,      ray.hit.v,         Ng}
                                       : Kept{ray.hit.geomID, 0, 0, 0, ray.ray.tfar, 0, 0, {0, 0, 0}};
    now.push_back(kept);
    if (!numbersMatter && host::isHit(ray)) now.back().geomID = 0;
  }

  /* Keeps whether a shadow ray is occluded. */
  void keep(const RTCRay& shadow) {
    const bool isOccluded = shadow.tfar < 0;
    now.push_back({isOccluded ? 1000 : RTC_INVALID_GEOMETRY_ID, 0, 0, 0, INFINITY, 0, 0, {0, 0, 0}});
  }

  bool numbersMatter = true; // compare IDs of geometries

  void begin(const char* use) { uses.push_back({use, now.size()}); }

  void conclude() {
    if (before.empty()) {
      FILE* const file = std::fopen(path, "wb");
      CHECK(file && std::fwrite(now.data(), sizeof(Kept), now.size(), file) == now.size());
      if (file) std::fclose(file);
      return;
    }
    CHECK(before.size() == now.size());
    uses.push_back({"", now.size()});
    for (size_t i = 0; i + 1 < uses.size(); i++)
      compare(uses[i].first, uses[i].second, std::min(before.size(), uses[i + 1].second));
  }

private:
  void compare(const char* use, size_t begin, size_t end) {
    size_t others = 0, hits = 0, turned = 0;
    float distance = 0;
    for (size_t i = begin; i < end; i++) {
      const Kept &a = before[i], &b = now[i];
      hits += a.geomID != RTC_INVALID_GEOMETRY_ID;
      const bool isSame = a.geomID == b.geomID && a.primID == b.primID && a.instID == b.instID &&
                          a.instPrimID == b.instPrimID && std::abs(a.u - b.u) < 0.01f && std::abs(a.v - b.v) < 0.01f;
      others += !isSame;
      if (!isSame || a.geomID == RTC_INVALID_GEOMETRY_ID || std::isinf(a.t)) continue;
      distance = std::max(distance, std::abs(a.t - b.t));
      turned += a.Ng[0] * b.Ng[0] + a.Ng[1] * b.Ng[1] + a.Ng[2] * b.Ng[2] < 0.95f;
    }
    std::printf(
        "%-14s %6zu rays, %6zu hits: %3zu with another surface, face or position, %zu with another normal; distances "
        "differ by %g at most\n",
        use, end - begin, hits, others, turned, double(distance));
    CHECK(hits > 0);
    CHECK(others * 500 < hits); // at silhouettes and between faces
    CHECK(turned * 500 < hits);
  }

  const char* const path;
  std::vector<Kept> before, now;
  std::vector<std::pair<const char*, size_t>> uses;
};

} // namespace stored_hits
