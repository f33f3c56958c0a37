// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "support/near_side.h"
#include "kernels/cbvh/paper/frame_fit.h"
#include "kernels/cbvh/paper/leaf/crossing.h"
#include "kernels/cbvh/paper/tree.h"
#include "support/scene_blocks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace programs::test {
namespace {

using namespace embree::cbvh;
constexpr double infinite = std::numeric_limits<double>::infinity();

class Walk {
public:
  Walk(const Block& block, const RTCRay& ray) : block(block), layout(block.layout()) {
    const float org[3] = {ray.org_x, ray.org_y, ray.org_z}, dir[3] = {ray.dir_x, ray.dir_y, ray.dir_z};
    double O[4] = {0.5, 0.5, 0.5, 1}, D[4] = {0, 0, 0, 0};
    for (int i = 0; i < 3; i++)
      for (int k = 0; k < 4; k++) {
        O[k] += double(block.columns[i][k]) * (double(org[i]) - double(block.center[i]));
        D[k] += double(block.columns[i][k]) * double(dir[i]);
      }
    begin = ray.tnear;
    end = ray.tfar;
    for (int k = 0; k < 3; k++) {
      clip(O[k] + slack, D[k], begin, end);
      clip(O[3] - O[k] + slack, D[3] - D[k], begin, end);
    }
    if (!(begin <= end)) return;
    w0 = O[3] + begin * D[3];
    w1 = O[3] + end * D[3];
    for (int k = 0; k < 3; k++) {
      P0[k] = (O[k] + begin * D[k]) / w0;
      P1[k] = (O[k] + end * D[k]) / w1;
    }
    visit(0, 0, rootBox());
  }

  double t = infinite; // no hit; otherwise at most the ray's tfar
  uint32_t leaf = 0;
  double u = 0, v = 0; // in the box of the leaf
  double Ng[3] = {0, 0, 0};

private:
  static constexpr double slack = 1e-6;

  // Clips [t0,t1] to the part where o + t d >= 0.
  static void clip(double o, double d, double& t0, double& t1) {
    if (d > 0) t0 = std::max(t0, -o / d);
    else if (d < 0) t1 = std::min(t1, -o / d);
    else if (o < 0) t1 = -infinite;
  }

  double at(int axis, double s) const { return P0[axis] + s * (P1[axis] - P0[axis]); }

  bool meets(const NodeBox& box, double& s0, double& s1) const {
    for (int k = 0; k < 3; k++) {
      clip(P0[k] - double(box.lower[k]) + slack, P1[k] - P0[k], s0, s1);
      clip(double(upperOf(box, k)) - P0[k] + slack, P0[k] - P1[k], s0, s1);
    }
    return s0 <= s1;
  }

  void visit(uint32_t level, uint32_t m, const NodeBox& box) {
    double s0 = 0, s1 = 1;
    if (!meets(box, s0, s1) || worldT(s0) >= t) return;
    const uint32_t node = block.nodes()[nodesOfLevels(level) + m];
    for (int c = 0; c < 4; c++) {
      const uint32_t child = 4 * m + uint32_t(c);
      if (level + 1 < layout.nodeLevels) {
        visit(level + 1, child, decodeChild(node, c, box));
        continue;
      }
      visitLeaf(child, decodeLeaf(node, heightsOf(&block, m), c, box));
    }
  }

  // Compares z with both patches where the ray enters and leaves: a hit at the entry, from above, or from below. The
  // interval is at least one bin of the paper's 4 bits around our surface.
  void visitLeaf(uint32_t m, const LeafPatch& leaf) {
    const NodeBox& box = leaf.box;
    double s0 = 0, s1 = 1;
    if (leaf.empty || !meets(box, s0, s1) || worldT(s0) >= t) return;
    if (leaf.solid) {
      hit(m, box, s0, 0, 0);
      return;
    }
    const double size = std::max(double(leaf.thickness), box.extent[2] / 16.0);
    const auto over = [&](double s) { // above the lower patch
      return at(2, s) - patchZ(leaf, inBox(box, s, 0), inBox(box, s, 1)) + 0.5 * size;
    };
    const double d0 = over(s0), d1 = over(s1);
    double s = s0;
    if (d0 > size && d1 <= size) s = s0 + (s1 - s0) * (d0 - size) / (d0 - d1);
    else if (d0 < 0 && d1 >= 0) s = s0 + (s1 - s0) * d0 / (d0 - d1);
    else if (d0 < 0 || d0 > size) return;
    const double u = inBox(box, s, 0), v = inBox(box, s, 1);
    const double twist = double(leaf.z[0]) - leaf.z[1] - leaf.z[2] + leaf.z[3];
    hit(m, box, s, (leaf.z[1] - leaf.z[0] + v * twist) / box.extent[0],
        (leaf.z[2] - leaf.z[0] + u * twist) / box.extent[1]);
  }

  double inBox(const NodeBox& box, double s, int axis) const {
    return std::clamp((at(axis, s) - double(box.lower[axis])) / double(box.extent[axis]), 0.0, 1.0);
  }

  double worldT(double s) const {
    const double sw = s * w0;
    return begin + sw / (w1 * (1 - s) + sw) * (end - begin);
  }

  void hit(uint32_t m, const NodeBox& box, double s, double slopeX, double slopeY) {
    if (!(worldT(s) < t)) return;
    t = worldT(s);
    leaf = m;
    u = inBox(box, s, 0);
    v = inBox(box, s, 1);
    const double k = at(2, s) - slopeX * at(0, s) - slopeY * at(1, s);
    for (int i = 0; i < 3; i++) {
      const float* c = block.columns[i];
      Ng[i] = -slopeX * c[0] - slopeY * c[1] + c[2] - k * c[3];
    }
  }

  const Block& block;
  BlockLayout layout;
  double begin, end; // world parameters of the segment's ends
  double P0[3], P1[3], w0, w1;
};

const Block& blockOf(void* user, unsigned primID) {
  return *(*static_cast<const std::vector<const Block*>*>(user))[primID];
}

void bounds(const RTCBoundsFunctionArguments* args) {
  const Block& b = blockOf(args->geometryUserPtr, args->primID);
  const FrameMap map = frameMap(&b);
  double lower[3] = {infinite, infinite, infinite}, upper[3] = {-infinite, -infinite, -infinite}, size = 0;
  for (int corner = 0; corner < 8; corner++) {
    Double3 p = {0, 0, 0};
    unproject(map, corner & 1, corner >> 1 & 1, corner >> 2, p);
    const double q[3] = {p.x + b.center[0], p.y + b.center[1], p.z + b.center[2]};
    for (int k = 0; k < 3; k++) {
      lower[k] = std::min(lower[k], q[k]);
      upper[k] = std::max(upper[k], q[k]);
      size = std::max({size, upper[k] - lower[k], std::fabs(q[k])});
    }
  }
  RTCBounds& o = *args->bounds_o;
  const double rim = 1e-5 * size;
  o.lower_x = float(lower[0] - rim);
  o.lower_y = float(lower[1] - rim);
  o.lower_z = float(lower[2] - rim);
  o.upper_x = float(upper[0] + rim);
  o.upper_y = float(upper[1] + rim);
  o.upper_z = float(upper[2] + rim);
}

void intersect(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  RTCRayHit& ray = *(RTCRayHit*)args->rayhit;
  const Block& block = blockOf(args->geometryUserPtr, args->primID);
  const Walk walk(block, ray.ray);
  if (!(walk.t < infinite)) return;
  ray.ray.tfar = float(walk.t);
  ray.hit.Ng_x = float(walk.Ng[0]);
  ray.hit.Ng_y = float(walk.Ng[1]);
  ray.hit.Ng_z = float(walk.Ng[2]);
  const double leafSize = double(1u << block.height()) / block.layout().leavesPerSide; // in quads
  ray.hit.u = block.faceU(float(leafSize * (mortonX(walk.leaf) + walk.u)));
  ray.hit.v = block.faceV(float(leafSize * (mortonY(walk.leaf) + walk.v)));
  ray.hit.primID = block.primID;
  ray.hit.geomID = args->geomID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

void occlude(const RTCOccludedFunctionNArguments* args) {
  if (!args->valid[0]) return;
  RTCRay& ray = *(RTCRay*)args->ray;
  if (Walk(blockOf(args->geometryUserPtr, args->primID), ray).t < infinite)
    ray.tfar = -std::numeric_limits<float>::infinity();
}

} // namespace

NearSideScene::NearSideScene(RTCScene compressed)
  : blocks(sceneBlocks(compressed)),
    device(rtcNewDevice("")),
    scene(rtcNewScene(device)) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, unsigned(blocks.size()));
  rtcSetGeometryUserData(geometry, &blocks);
  rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect);
  rtcSetGeometryOccludedFunction(geometry, occlude);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
}

NearSideScene::~NearSideScene() {
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
}

} // namespace programs::test
