// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "input.h"

#include "grid_bytes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <string>

namespace interposer {

void check(CbvhError error) {
  if (error == CBVH_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (error != CBVH_OK) throw Unsupported(cbvhGetErrorText());
}

namespace {

void displace(const CbvhDisplacementArguments* args) {
  const Input& input = *(const Input*)args->userPtr;
  const RTCDisplacementFunctionNArguments embreeArgs = {
      *input.userData, input.original, args->primID, args->timeStep, args->u,   args->v,    args->Ng_x,
      args->Ng_y,      args->Ng_z,     args->P_x,    args->P_y,      args->P_z, args->count};
  input.displacement(&embreeArgs);
}

CbvhBoundary boundaryOf(RTCSubdivisionMode mode) {
  switch (mode) {
  case RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY: return CBVH_BOUNDARY_SMOOTH;
  case RTC_SUBDIVISION_MODE_PIN_CORNERS: return CBVH_BOUNDARY_PIN_CORNERS;
  case RTC_SUBDIVISION_MODE_PIN_BOUNDARY: return CBVH_BOUNDARY_PIN_BOUNDARY;
  case RTC_SUBDIVISION_MODE_PIN_ALL: return CBVH_BOUNDARY_PIN_ALL;
  default: throw Unsupported("RTC_SUBDIVISION_MODE_NO_BOUNDARY is not supported");
  }
}

/* A buffer as a contiguous array: a copy if its stride is not the size of an item. Empty if there is no buffer. */
template<typename T>
class Packed {
public:
  Packed() = default;
  explicit Packed(const Buffer* buffer) {
    if (!buffer || !buffer->data || buffer->count == 0) return;
    count = buffer->count;
    data = (const T*)buffer->data;
    if (buffer->stride == sizeof(T)) return;
    copy.resize(count);
    for (size_t i = 0; i < count; i++) std::memcpy(&copy[i], buffer->data + i * buffer->stride, sizeof(T));
    data = copy.data();
  }
  Packed(Packed&&) = default;
  Packed& operator=(Packed&&) = default;

  const T* data = nullptr;
  size_t count = 0;

private:
  std::vector<T> copy;
};

struct Pair {
  unsigned int first, second;
};
struct Corners3 {
  unsigned int v[3];
};
struct Corners4 {
  unsigned int v[4];
};

} // namespace

const Buffer* Input::find(RTCBufferType type, unsigned int slot) const {
  const auto found = buffers.find({type, slot});
  if (found == buffers.end()) return nullptr;
  if (found->second.isOutOfBounds) throw Unsupported("the range of one of its buffers is out of bounds");
  return &found->second;
}

CbvhVertices Input::vertices(std::vector<const float*>& steps) const {
  CbvhVertices result = CbvhVertices();
  if (numTimeSteps == 0) throw Unsupported("it has no time steps");
  for (unsigned int i = 0; i < numTimeSteps; i++) {
    const Buffer* const buffer = find(RTC_BUFFER_TYPE_VERTEX, i);
    if (!buffer || !buffer->data || buffer->count == 0) throw Unsupported("it has no vertices");
    if (i > 0 && (buffer->stride != result.stride || buffer->count != result.numVertices))
      throw Unsupported("its time steps differ in the stride or the number of vertices");
    result.stride = buffer->stride;
    result.numVertices = buffer->count;
    steps.push_back((const float*)buffer->data);
  }
  result.steps = steps.data();
  result.numSteps = numTimeSteps;
  result.startTime = startTime;
  result.endTime = endTime;
  return result;
}

void Input::applyTo(CbvhSurface surface) const {
  if (isIncomplete) throw Unsupported("out of memory for one of its buffers");
  if (type == RTC_GEOMETRY_TYPE_SUBDIVISION) applyCage(surface);
  else if (type == RTC_GEOMETRY_TYPE_GRID) applyGrids(surface);
  else applyMesh(surface);
}

void Input::applyCage(CbvhSurface surface) const {
  std::vector<const float*> steps;
  CbvhCage cage = CbvhCage();
  cage.vertices = vertices(steps);

  const Packed<unsigned int> faces(find(RTC_BUFFER_TYPE_FACE)), indices(find(RTC_BUFFER_TYPE_INDEX)),
      holes(find(RTC_BUFFER_TYPE_HOLE)), corners(find(RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX));
  const Packed<float> levels(find(RTC_BUFFER_TYPE_LEVEL)), creaseWeights(find(RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT)),
      cornerWeights(find(RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT));
  const Packed<Pair> creases(find(RTC_BUFFER_TYPE_EDGE_CREASE_INDEX));
  if (!faces.data || !indices.data) throw Unsupported("it has no faces or no indices");
  cage.numFaces = faces.count;
  cage.faceVertexCounts = faces.data;
  cage.indices = indices.data;
  for (size_t i = 0; i < faces.count; i++) {
    if (faces.data[i] < 3) throw Unsupported("it has a face with fewer than 3 vertices");
    cage.numIndices += faces.data[i];
  }
  if (cage.numIndices > indices.count) throw Unsupported("it has fewer indices than its faces have vertices");

  /* bounds to which Embree clamps rates */
  const auto clamped = [](float rate) { return rate >= 1 ? std::min(rate, 4096.0f) : 1.0f; };
  std::vector<float> rates;
  cage.rate = clamped(tessellationRate);
  if (levels.data) {
    if (levels.count < cage.numIndices) throw Unsupported("it has fewer levels than its faces have edges");
    rates.resize(cage.numIndices);
    std::transform(levels.data, levels.data + cage.numIndices, rates.begin(), clamped);
    cage.rates = rates.data();
  }
  cage.boundary = boundaryOf(mode);
  cage.numCreases = std::min(creases.count, creaseWeights.count);
  cage.creases = (const unsigned int*)creases.data;
  cage.creaseSharpness = creaseWeights.data;
  cage.numCorners = std::min(corners.count, cornerWeights.count);
  cage.corners = corners.data;
  /* Embree rounds corners of any finite sharpness, from 10 on all like this one. In cbvh.h, 10 means infinity. */
  const float sharpest = std::nextafter(10.0f, 0.0f);
  std::vector<float> sharpness(cornerWeights.data, cornerWeights.data + cage.numCorners);
  for (float& s : sharpness)
    if (std::isfinite(s)) s = std::min(s, sharpest);
  cage.cornerSharpness = sharpness.data();
  cage.numHoles = holes.count;
  cage.holes = holes.data;
  if (displacement) {
    cage.displacement = displace;
    cage.displacementUserPtr = (void*)this;
  }
  check(cbvhSetSurfaceCage(surface, &cage));
}

void Input::applyGrids(CbvhSurface surface) const {
  static_assert(sizeof(CbvhGrid) == sizeof(RTCGrid), "CbvhGrid must have the layout of RTCGrid");
  std::vector<const float*> steps;
  const Packed<CbvhGrid> packed(find(RTC_BUFFER_TYPE_GRID));
  CbvhGrids grids = CbvhGrids();
  grids.numGrids = packed.count;
  grids.grids = packed.data;
  grids.vertices = vertices(steps);
  if (grids.numGrids == 0) throw Unsupported("it has no grids");
  embree::GridBytes bytes;
  for (size_t i = 0; i < packed.count; i++)
    bytes = bytes + embree::bytesOfGrid(packed.data[i].width, packed.data[i].height, numTimeSteps, hasWideNodes);
  if (!bytes.areBlocksSmaller()) throw Unsupported("its grids are so small that Embree needs less memory for them");
  check(cbvhSetSurfaceGrids(surface, &grids));
}

void Input::applyMesh(CbvhSurface surface) const {
  std::vector<const float*> steps;
  CbvhMesh mesh = CbvhMesh();
  Packed<Corners3> triangles;
  Packed<Corners4> quads;
  if (type == RTC_GEOMETRY_TYPE_QUAD) {
    quads = Packed<Corners4>(find(RTC_BUFFER_TYPE_INDEX));
    mesh.verticesPerFace = 4;
    mesh.numFaces = quads.count;
    mesh.indices = (const unsigned int*)quads.data;
  } else {
    triangles = Packed<Corners3>(find(RTC_BUFFER_TYPE_INDEX));
    mesh.verticesPerFace = 3;
    mesh.numFaces = triangles.count;
    mesh.indices = (const unsigned int*)triangles.data;
  }
  if (mesh.numFaces == 0) throw Unsupported("it has no quads or triangles");
  if (mesh.numFaces < 256) throw Unsupported("it has too few quads or triangles to matter: Embree traces them faster");
  if (isRefitted) throw Unsupported("it has RTC_BUILD_QUALITY_REFIT");
  mesh.vertices = vertices(steps);
  check(cbvhSetSurfaceMesh(surface, &mesh));
}

} // namespace interposer
