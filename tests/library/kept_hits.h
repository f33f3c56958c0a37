// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Text files of tests/library/kept_files: vertices and hits of a compressed file. All floats are hexadecimal.
 *
 *     vertex BLOCK STEP INDEX X Y Z
 *     ray X Y Z DX DY DZ TIME
 *     hit PRIMID T U V NX NY NZ
 *     miss
 *
 * Lines that begin with # are comments. A vertex is what the scalar decoder returns. A ray starts at tnear 0 and has no
 * end. The line after it is its closest hit, or "miss". */

#include "support/scene.h"

#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace programs::test {

struct KeptVertex {
  unsigned block, step, index; // block: in the order of the file
  Vec position;
};

struct KeptHits {
  std::vector<KeptVertex> vertices;
  std::vector<RTCRayHit> rays, hits; // hits[i].hit.geomID is 0 or RTC_INVALID_GEOMETRY_ID
};

// Throws std::runtime_error if the file is missing or has an invalid line.
inline KeptHits readKeptHits(const std::string& path) {
  KeptHits all;
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot open " + path);
  for (std::string line; std::getline(file, line);) {
    const char* const text = line.c_str();
    KeptVertex vertex;
    Vec p, d;
    float time;
    RTCHit hit = RTCHit();
    if (line.empty() || line[0] == '#') continue;
    if (std::sscanf(text, "vertex %u %u %u %f %f %f", &vertex.block, &vertex.step, &vertex.index, &p[0], &p[1],
                    &p[2]) == 6) {
      vertex.position = p;
      all.vertices.push_back(vertex);
    } else if (std::sscanf(text, "ray %f %f %f %f %f %f %f", &p[0], &p[1], &p[2], &d[0], &d[1], &d[2], &time) == 7) {
      all.rays.push_back(makeRay(p, d));
      all.rays.back().ray.time = time;
      all.hits.push_back(all.rays.back());
    } else if (!all.hits.empty() &&
               std::sscanf(text, "hit %u %f %f %f %f %f %f", &hit.primID, &all.hits.back().ray.tfar, &hit.u, &hit.v,
                           &hit.Ng_x, &hit.Ng_y, &hit.Ng_z) == 7) {
      hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      all.hits.back().hit = hit;
    } else if (line != "miss") throw std::runtime_error("invalid line in " + path + ": " + line);
  }
  return all;
}

inline void writeKeptHits(const std::string& path, const std::string& description, const KeptHits& all) {
  FILE* const file = std::fopen(path.c_str(), "wx"); // fails if the file exists
  if (!file) throw std::runtime_error("cannot create " + path);
  std::fprintf(file, "# %s\n", description.c_str());
  for (const KeptVertex& v : all.vertices)
    std::fprintf(file, "vertex %u %u %u %a %a %a\n", v.block, v.step, v.index, v.position[0], v.position[1],
                 v.position[2]);
  for (size_t i = 0; i < all.rays.size(); i++) {
    const RTCRay& r = all.rays[i].ray;
    const RTCHit& h = all.hits[i].hit;
    std::fprintf(file, "ray %a %a %a %a %a %a %a\n", r.org_x, r.org_y, r.org_z, r.dir_x, r.dir_y, r.dir_z, r.time);
    if (isHit(all.hits[i]))
      std::fprintf(file, "hit %u %a %a %a %a %a %a\n", h.primID, all.hits[i].ray.tfar, h.u, h.v, h.Ng_x, h.Ng_y,
                   h.Ng_z);
    else std::fprintf(file, "miss\n");
  }
  if (std::fclose(file) != 0) throw std::runtime_error("cannot write " + path);
}

} // namespace programs::test
