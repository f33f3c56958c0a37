// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "embree_terrain.h"

#include <embree3/rtcore_compression.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace programs {

EmbreeTerrain::EmbreeTerrain(const std::string& kernel)
  : device(""),
    scene(rtcNewScene(device.handle())),
    kernel(kernel) {
  /* Many rays run exactly along edges and would otherwise pass between triangles. */
  rtcSetSceneFlags(scene.get(), RTCSceneFlags(RTC_SCENE_FLAG_COMPACT | RTC_SCENE_FLAG_ROBUST));
}

void EmbreeTerrain::add(const TerrainTile& tile) {
  const bool isGrid = kernel == "grid", isQuad = kernel == "quad";
  const unsigned w = unsigned(tile.width), h = unsigned(tile.height);
  const size_t tileQuads = size_t(w - 1) * size_t(h - 1);
  const GeometryHandle geometry(rtcNewGeometry(device.handle(), isGrid   ? RTC_GEOMETRY_TYPE_GRID
                                                                : isQuad ? RTC_GEOMETRY_TYPE_QUAD
                                                                         : RTC_GEOMETRY_TYPE_TRIANGLE));
  Vec3f* const vertices = newBuffer<Vec3f>(device, geometry.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3,
                                           size_t(w) * h, "copying vertices");
  std::copy_n(tile.vertices.begin(), size_t(w) * h, vertices);
  if (isGrid) {
    const RTCGrid grid = {0, w, (unsigned short)w, (unsigned short)h};
    *newBuffer<RTCGrid>(device, geometry.get(), RTC_BUFFER_TYPE_GRID, RTC_FORMAT_GRID, 1, "setting the grid") = grid;
  } else {
    using Quad = std::array<unsigned, 4>;
    using Triangle = std::array<unsigned, 3>;
    Quad* const quad = isQuad ? newBuffer<Quad>(device, geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT4,
                                                tileQuads, "setting quads")
                              : nullptr;
    Triangle* const triangle = isQuad ? nullptr
                                      : newBuffer<Triangle>(device, geometry.get(), RTC_BUFFER_TYPE_INDEX,
                                                            RTC_FORMAT_UINT3, 2 * tileQuads, "setting triangles");
    size_t i = 0;
    for (unsigned y = 0; y + 1 < h; y++)
      for (unsigned x = 0; x + 1 < w; x++, i++) {
        const unsigned a = y * w + x, b = a + 1, c = a + w, d = c + 1;
        if (isQuad) quad[i] = {a, b, d, c};
        else {
          triangle[2 * i] = {a, b, c};
          triangle[2 * i + 1] = {d, c, b};
        }
      }
  }
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = RTC_COMPRESSION_NONE; // overrides the environment
  rtcSetGeometryCompression(geometry.get(), &args);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometry(scene.get(), geometry.get());
  device.check("adding a tile");
  quads += tileQuads;
}

void EmbreeTerrain::commit() {
  rtcCommitScene(scene.get());
  device.check("building the tree");
}

bool EmbreeTerrain::isOccluded(CbvhRay ray) const {
  static_assert(sizeof(RTCRay) == sizeof(CbvhRay), "rays of both libraries have the same layout");
  RTCRay copy;
  std::memcpy(&copy, &ray, sizeof(copy));
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene.get(), &context, &copy);
  return copy.tfar < 0;
}

} // namespace programs
