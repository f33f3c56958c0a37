// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A renderer on Embree 4 or 3.13 with a displaced subdivision surface of libembree_cbvh in its scene:
 *
 *   c++ -std=c++17 displaced_cage.cpp $(pkg-config --cflags --libs embree_cbvh) -lembree4
 *   ./a.out cage.pgm */

#include "picture.h"
#include <cbvh/embree.h>

#include <cstdlib>

static void check(CbvhError error) {
  if (error == CBVH_OK) return;
  std::fprintf(stderr, "displaced_cage: %s\n", cbvhGetErrorText());
  std::exit(1);
}

// Moves points of the limit surface along its normals.
static void displace(const CbvhDisplacementArguments* args) {
  for (unsigned i = 0; i < args->count; i++) {
    const float height =
        0.04f * std::sin(23 * args->P_x[i]) * std::sin(19 * args->P_y[i]) * std::sin(29 * args->P_z[i]);
    args->P_x[i] += height * args->Ng_x[i];
    args->P_y[i] += height * args->Ng_y[i];
    args->P_z[i] += height * args->Ng_z[i];
  }
}

int main(int argc, char** argv) {
  CbvhContext context;
  CbvhSurface surface;
  CbvhGroup group;
  check(cbvhNewContext(nullptr, nullptr, nullptr, &context));
  check(cbvhNewSurface(context, &surface));

  // A cube with 512 x 512 quads per face.
  const float positions[8][3] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                 {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
  const float* const steps[1] = {positions[0]};
  const unsigned faceVertexCounts[6] = {4, 4, 4, 4, 4, 4};
  const unsigned indices[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  CbvhCage cage = CbvhCage();
  cage.numFaces = 6;
  cage.faceVertexCounts = faceVertexCounts;
  cage.numIndices = 24;
  cage.indices = indices;
  cage.vertices = {8, sizeof(positions[0]), steps, 1, 0, 0};
  cage.rate = 512;
  cage.displacement = displace;
  check(cbvhSetSurfaceCage(surface, &cage));
  check(cbvhCommitSurface(surface, nullptr, nullptr));
  check(cbvhNewGroup(context, &surface, 1, &group));
  check(cbvhCommitGroup(group));
  cbvhReleaseSurface(surface);

  // The group is a geometry like any other.
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = cbvhNewGeometry(device, group, 0);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);

  CbvhGroupStatistics statistics;
  check(cbvhGetGroupStatistics(group, &statistics));
  const double share = writePicture(scene, argc > 1 ? argv[1] : "displaced_cage.pgm", 512, 1);
  std::printf("Embree %s: %.2f million quads in %.2f MiB; %.0f%% of the rays hit\n", RTC_VERSION_STRING,
              double(statistics.numQuads) * 1e-6, double(statistics.bytes) / (1 << 20), 100 * share);

  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  cbvhReleaseGroup(group);
  cbvhReleaseContext(context);
  return share > 0.1 ? 0 : 1;
}
