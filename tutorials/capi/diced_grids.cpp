// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A renderer on Embree 4 or 3.13 that dices its surfaces itself, at both ends of the shutter, and passes the grids to
 * libembree_cbvh. The renderer frees its vertices before the first ray.
 *
 *   c++ -std=c++17 diced_grids.cpp $(pkg-config --cflags --libs embree_cbvh) -lembree4
 *   ./a.out grids.pgm */

#include "picture.h"
#include <cbvh/embree.h>

#include <array>
#include <cstdlib>

static void check(CbvhError error) {
  if (error == CBVH_OK) return;
  std::fprintf(stderr, "diced_grids: %s\n", cbvhGetErrorText());
  std::exit(1);
}

// A dicer: 16 x 8 grids of 65 x 65 vertices on a ball that rotates.
struct Diced {
  std::vector<std::array<float, 3>> vertices;
  std::vector<CbvhGrid> grids;

  explicit Diced(float time) {
    const unsigned n = 65;
    for (unsigned gy = 0; gy < 8; gy++)
      for (unsigned gx = 0; gx < 16; gx++) {
        grids.push_back({unsigned(vertices.size()), n, n, n});
        for (unsigned y = 0; y < n; y++)
          for (unsigned x = 0; x < n; x++) {
            // the last column equals the first
            const unsigned column = (gx * (n - 1) + x) % (16 * (n - 1)), row = gy * (n - 1) + y;
            const float phi = 6.2831853f * float(column) / float(16 * (n - 1));
            const float theta = 3.1415927f * float(row) / float(8 * (n - 1));
            const float r = 1 + 0.05f * std::sin(17 * phi) * std::sin(13 * theta), turned = phi + 0.3f * time;
            const float width = row == 0 || row == 8 * (n - 1) ? 0 : std::sin(theta); // poles are points
            vertices.push_back({r * width * std::cos(turned), r * std::cos(theta), r * width * std::sin(turned)});
          }
      }
    vertices.push_back({0, 0, 0}); // padding that Embree may read
  }
};

int main(int argc, char** argv) {
  CbvhContext context;
  CbvhSurface surface;
  CbvhGroup group;
  check(cbvhNewContext(nullptr, nullptr, nullptr, &context));
  check(cbvhNewSurface(context, &surface));
  {
    const Diced atOpen(0), atClose(1);
    const float* const steps[2] = {atOpen.vertices[0].data(), atClose.vertices[0].data()};
    CbvhGrids grids = CbvhGrids();
    grids.numGrids = atOpen.grids.size();
    grids.grids = atOpen.grids.data();
    grids.vertices = {atOpen.vertices.size() - 1, sizeof(atOpen.vertices[0]), steps, 2, 0, 1};
    check(cbvhSetSurfaceGrids(surface, &grids));
    check(cbvhCommitSurface(surface, nullptr, nullptr));
  } // this frees the vertices
  check(cbvhNewGroup(context, &surface, 1, &group));
  check(cbvhCommitGroup(group));
  cbvhReleaseSurface(surface);

  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = cbvhNewGeometry(device, group, 0);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);

  CbvhGroupStatistics statistics;
  check(cbvhGetGroupStatistics(group, &statistics));
  const double share = writePicture(scene, argc > 1 ? argv[1] : "diced_grids.pgm", 512, 8);
  std::printf("Embree %s: %.2f million moving quads in %.2f MiB; %.0f%% of the rays hit\n", RTC_VERSION_STRING,
              double(statistics.numMovingQuads) * 1e-6, double(statistics.bytes) / (1 << 20), 100 * share);

  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  cbvhReleaseGroup(group);
  cbvhReleaseContext(context);
  return share > 0.1 ? 0 : 1;
}
