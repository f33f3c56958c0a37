// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "programs/view_options.h"
#include "basics/error.h"
#include "surface/up_axis.h"
#include "tracing/trace_hits.h"

#include <algorithm>
#include <charconv>
#include <system_error>

namespace programs {
namespace {

constexpr float fieldOfView = 35.0f;

/* Looks at the surface that the full view shows at or nearest to a given place. */
Camera closeCamera(const Camera& full, const TracedScene& scene, const ViewHints& hints, unsigned threads) {
  const ImageSize size = full.size();
  const std::vector<Ray> rays = primaryRays(full);
  const std::vector<SurfaceHit> hits = traceClosest(scene, rays, threads);
  const float cx = hints.closePoint.x * float(size.width), cy = hints.closePoint.y * float(size.height);
  float best = INFINITY;
  size_t pixel = 0;
  for (size_t i = 0; i < hits.size(); i++) {
    const float dx = float(i % size_t(size.width)) - cx, dy = float(i / size_t(size.width)) - cy;
    if (hits[i].hit() && dx * dx + dy * dy < best) {
      best = dx * dx + dy * dy;
      pixel = i;
    }
  }
  if (best == INFINITY)
    throw Error("the close view needs a surface in the full view, which shows none: expected another --view");
  const Vec3f target = rays[pixel].origin + hits[pixel].t * rays[pixel].direction;
  const float distance = hints.closeDistance * scene.bounds().diagonal();
  return Camera(target - distance * rays[pixel].direction, target, hints.up, full.fov(), size);
}

/* Positions of the vertices that faces use; of all vertices if there are no faces. */
std::vector<Vec3f> positionsOfFaces(const Model& model) {
  std::vector<Vec3f> positions = model.positions();
  if (model.cage.faceIndices.empty()) return positions;
  const size_t numVertices = model.cage.positions.size();
  std::vector<char> isUsed(numVertices);
  for (unsigned vertex : model.cage.faceIndices) isUsed[vertex] = 1;
  size_t used = 0;
  for (size_t i = 0; i < positions.size(); i++)
    if (isUsed[i % numVertices]) positions[used++] = positions[i];
  positions.resize(used);
  return positions;
}

/* The box of an empty scene is infinite. */
bool hasSurface(const Box3f& bounds) { return isFinite(bounds.lower) && isFinite(bounds.upper); }

bool parseNumbers(const std::string& text, float* x, int n) {
  const char* p = text.data();
  const char* const end = p + text.size();
  for (int i = 0; i < n; i++) {
    const auto [next, code] = std::from_chars(p, end, x[i]);
    if (code != std::errc() || !std::isfinite(x[i]) || (i < n - 1 ? next == end || *next != ',' : next != end))
      return false;
    p = next + 1;
  }
  return true;
}

} // namespace

Shutter parseShutter(const std::string& text) {
  float x[2];
  if (!parseNumbers(text, x, 2) || !(0 <= x[0] && x[0] <= x[1] && x[1] <= 1))
    throw Error("invalid --shutter '" + text + "': expected two times from 0 to 1 in ascending order, as in 0,1");
  return {x[0], x[1]};
}

Vec3f parsePosition(const std::string& text) {
  float x[3];
  if (!parseNumbers(text, x, 3)) throw Error("invalid --position '" + text + "': expected x,y,z");
  return {x[0], x[1], x[2]};
}

ImageSize parseImageSize(const std::string& text) {
  ImageSize size;
  const char* const end = text.data() + text.size();
  const auto w = std::from_chars(text.data(), end, size.width);
  if (w.ec == std::errc() && w.ptr != end && *w.ptr == 'x') {
    const auto h = std::from_chars(w.ptr + 1, end, size.height);
    if (h.ec == std::errc() && h.ptr == end && size.width > 0 && size.height > 0 && size.width <= 16384 &&
        size.height <= 16384)
      return size;
  }
  throw Error("invalid --size '" + text + "': expected WIDTHxHEIGHT with 1 to 16384 pixels each");
}

Crop parseCrop(const std::string& text, ImageSize whole) {
  if (text.empty()) return Crop(whole);
  int x[4];
  const char* p = text.data();
  const char* const end = p + text.size();
  for (int i = 0; i < 4; i++) {
    const auto [next, code] = std::from_chars(p, end, x[i]);
    if (code != std::errc() || (i < 3 ? next == end || *next != ',' : next != end))
      throw Error("invalid --crop '" + text + "': expected x0,y0,x1,y1 in pixels");
    p = next + 1;
  }
  const Crop crop(x[0], x[1], x[2], x[3]);
  if (crop.x0 >= crop.x1 || crop.y0 >= crop.y1)
    throw Error("invalid --crop '" + text + "': the part is empty; expected x0 < x1 and y0 < y1");
  if (crop.x0 < 0 || crop.y0 < 0 || crop.x1 > whole.width || crop.y1 > whole.height)
    throw Error("invalid --crop '" + text + "': expected a part of the picture, which has " +
                std::to_string(whole.width) + "x" + std::to_string(whole.height) + " pixels");
  return crop;
}

Camera parseView(const std::string& text, Vec3f up, ImageSize size) {
  float x[7];
  const bool isRead = parseNumbers(text, x, 7);
  if (!isRead || !(x[6] > 0.0f && x[6] < 180.0f) || length(Vec3f{x[3] - x[0], x[4] - x[1], x[5] - x[2]}) == 0.0f)
    throw Error("invalid --view '" + text +
                "': expected full, close, or eye, target and field of view in degrees as "
                "ex,ey,ez,lx,ly,lz,fov");
  return Camera({x[0], x[1], x[2]}, {x[3], x[4], x[5]}, up, x[6], size);
}

Camera fitCamera(const Model& model, const Box3f& surface, const ViewHints& hints, float fov, ImageSize size) {
  const std::vector<Vec3f> positions = positionsOfFaces(model);
  Box3f cage;
  for (const Vec3f& p : positions) cage.extend(p);
  const Vec3f below = cage.lower - surface.lower, above = surface.upper - cage.upper;
  const float beyond = std::max({0.0f, below.x, below.y, below.z, above.x, above.y, above.z});
  return Camera::fit(positions, beyond, hints, fov, size);
}

Camera chooseCamera(const std::string& view, const Model& model, const TracedScene& scene, ImageSize size,
                    unsigned threads) {
  const Box3f bounds = scene.bounds();
  if (!hasSurface(bounds))
    throw Error(model.name + ": Embree tessellates no face of this cage: expected faces that are neither holes nor "
                             "invalid");
  if (view != "full" && view != "close") return parseView(view, model.view.up, size);
  const Camera full = fitCamera(model, bounds, model.view, fieldOfView, size);
  return view == "full" ? full : closeCamera(full, scene, model.view, threads);
}

Model boxModel(const std::string& name, const Box3f& b, const std::string& up) {
  if (!hasSurface(b)) throw Error(name + ": the file contains no visible surface: expected at least one");
  Model model;
  model.name = name;
  if (!up.empty() && up != "auto") {
    model.up = up;
    model.view = rotatedFromY(model.view, up);
  }
  for (int i = 0; i < 8; i++)
    model.cage.positions.push_back(
        {i & 1 ? b.upper.x : b.lower.x, i & 2 ? b.upper.y : b.lower.y, i & 4 ? b.upper.z : b.lower.z});
  return model;
}

} // namespace programs
