// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Camera rays through a scene of Embree 3 or 4, and a picture of normals as PGM. */

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

inline void intersect(RTCScene scene, RTCRayHit& ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &ray, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray);
#endif
}

/* Renders an object of width 2 around the origin, with `samples` per pixel at different times. Returns the fraction
 * of rays that hit. */
inline double writePicture(RTCScene scene, const char* path, int size, int samples) {
  std::vector<unsigned char> pixels;
  size_t hits = 0;
  for (int y = 0; y < size; y++)
    for (int x = 0; x < size; x++) {
      float light = 0;
      for (int s = 0; s < samples; s++) {
        RTCRayHit r;
        std::memset(&r, 0, sizeof(r));
        r.ray.org_x = 3.2f;
        r.ray.org_y = 2.4f;
        r.ray.org_z = 4;
        const float u = 0.3f * (2 * (float(x) + 0.5f) / float(size) - 1);
        const float v = 0.3f * (1 - 2 * (float(y) + 0.5f) / float(size));
        r.ray.dir_x = -0.566f + 0.781f * u - 0.265f * v;
        r.ray.dir_y = -0.424f + 0.906f * v;
        r.ray.dir_z = -0.707f - 0.625f * u - 0.331f * v;
        r.ray.time = (float(s) + 0.5f) / float(samples);
        r.ray.tfar = INFINITY;
        r.ray.mask = ~0u;
        r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        intersect(scene, r);
        if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
        hits++;
        const float n = std::sqrt(r.hit.Ng_x * r.hit.Ng_x + r.hit.Ng_y * r.hit.Ng_y + r.hit.Ng_z * r.hit.Ng_z);
        light += std::fabs(0.3f * r.hit.Ng_x + 0.9f * r.hit.Ng_y + 0.3f * r.hit.Ng_z) / n;
      }
      pixels.push_back((unsigned char)(255 * std::fmin(light / float(samples), 1.0f)));
    }
  FILE* const file = std::fopen(path, "wb");
  bool isWritten = file && std::fprintf(file, "P5\n%d %d\n255\n", size, size) > 0;
  isWritten = isWritten && std::fwrite(pixels.data(), 1, pixels.size(), file) == pixels.size();
  if (!file || std::fclose(file) != 0 || !isWritten) {
    std::perror(path);
    std::exit(1);
  }
  return double(hits) / (double(size) * size * samples);
}
