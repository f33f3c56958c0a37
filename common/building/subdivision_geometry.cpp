// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/subdivision_geometry.h"
#include "basics/progress.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace programs {
namespace {

/* Rounds a parameter to a multiple of 2^-16. Embree's grids may end a face at 0.99999994 instead of 1. Displacements
 * that treat the borders of faces specially would not recognize such a border, and the surface would tear. */
float snap(float parameter) { return std::nearbyint(parameter * 0x1p16f) * 0x1p-16f; }

constexpr size_t batchSize = 256; // points per call of a displacement

/* Displaces points.n points of args, from index `begin` on. */
void displaceAlongNormals(const RTCDisplacementFunctionNArguments* args, const DisplacementContext& context,
                          size_t begin, const SurfacePoints& points) {
  float offsets[batchSize];
  context.displacement->offsets(points, offsets);
  for (size_t i = 0; i < points.n; i++) {
    offsets[i] *= context.placement.scale;
    args->P_x[begin + i] += offsets[i] * args->Ng_x[begin + i];
    args->P_y[begin + i] += offsets[i] * args->Ng_y[begin + i];
    args->P_z[begin + i] += offsets[i] * args->Ng_z[begin + i];
  }
}

void displaceByVectors(const RTCDisplacementFunctionNArguments* args, const DisplacementContext& context, size_t begin,
                       const SurfacePoints& points) {
  const Placement& placement = context.placement;
  Vec3f normals[batchSize], vectors[batchSize];
  for (size_t i = 0; i < points.n; i++)
    normals[i] = placement.normalToCage({args->Ng_x[begin + i], args->Ng_y[begin + i], args->Ng_z[begin + i]});
  context.displacement->vectors(points, normals, vectors);
  for (size_t i = 0; i < points.n; i++) {
    const Vec3f moved = placement.vectorFromCage(vectors[i]);
    args->P_x[begin + i] += moved.x;
    args->P_y[begin + i] += moved.y;
    args->P_z[begin + i] += moved.z;
  }
}

void displace(const RTCDisplacementFunctionNArguments* args) {
  throwIfCanceled(); // early, because Embree calls its progress monitor rarely
  const DisplacementContext& context = *static_cast<const DisplacementContext*>(args->geometryUserPtr);
  float u[batchSize], v[batchSize], levels[batchSize];
  for (size_t begin = 0; context.displacement && begin < args->N; begin += batchSize) {
    const size_t n = std::min<size_t>(batchSize, args->N - begin);
    std::transform(args->u + begin, args->u + begin + n, u, snap);
    std::transform(args->v + begin, args->v + begin + n, v, snap);
    SurfacePoints points{args->primID, context.level, n, u, v};
    points.gaps = context.gaps;
    if (context.rates) {
      for (size_t i = 0; i < n; i++) levels[i] = context.rates->level(*context.copy, args->primID, u[i], v[i]);
      points.levels = levels;
    }
    if (context.displacement->isAlongNormals()) displaceAlongNormals(args, context, begin, points);
    else displaceByVectors(args, context, begin, points);
  }
  if (context.progress) context.progress->add(args->N);
  if (!context.captured || args->timeStep != 0) return;
  for (size_t i = 0; i < args->N; i++) {
    float u = args->u[i], v = args->v[i];
    const Patch& patch = context.layout->find(args->primID, u, v);
    if (!context.layout->isQuadFace(args->primID)) decodeSubPatch(u, v);
    const size_t x = size_t(std::lround(u * float(patch.resolution)));
    const size_t y = size_t(std::lround(v * float(patch.resolution)));
    float* out = context.captured + 3 * (patch.firstVertex + y * (patch.resolution + 1) + x);
    out[0] = args->P_x[i];
    out[1] = args->P_y[i];
    out[2] = args->P_z[i];
  }
}

RTCSubdivisionMode subdivisionMode(BoundaryRule rule) {
  switch (rule) {
  case BoundaryRule::None: return RTC_SUBDIVISION_MODE_NO_BOUNDARY;
  case BoundaryRule::EdgeAndCorner: return RTC_SUBDIVISION_MODE_PIN_CORNERS;
  default: return RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY;
  }
}

} // namespace

/* Most calls take no lock, because Embree displaces grids of 8 x 8 quads and millions of points per second. */
void TessellationProgress::add(size_t points) {
  constexpr double pointsPerQuad = 1.3; // 9 x 9 points, rounded up
  constexpr size_t interval = 1 << 14;
  const size_t before = done.fetch_add(points);
  if (before / interval != (before + points) / interval)
    phase.update(double(before + points) / (pointsPerQuad * double(quads)));
}

void setDisplacement(DisplacementContext& context, const Model& model, size_t copy, int level, const EdgeRates* rates) {
  context.displacement = model.displacement.get();
  context.level = level;
  context.rates = rates;
  context.copy = rates ? &rates->copies[copy] : nullptr;
}

template<typename T>
void SharedTopology::add(RTCBufferType type, RTCFormat format, const std::vector<T>& data) {
  if (data.empty()) return;
  BufferHandle buffer(rtcNewBuffer(device.handle(), sizeof(T) * data.size()));
  device.check("allocating a buffer of the cage");
  std::memcpy(rtcGetBufferData(buffer.get()), data.data(), sizeof(T) * data.size());
  buffers.push_back({type, format, sizeof(T), data.size(), std::move(buffer)});
}

SharedTopology::SharedTopology(EmbreeDevice& device, const Cage& cage, const std::vector<std::vector<Vec3f>>& poses)
  : device(device),
    cage(cage),
    poses(poses) {
  add(RTC_BUFFER_TYPE_FACE, RTC_FORMAT_UINT, cage.faceSizes);
  add(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, cage.faceIndices);
  add(RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, RTC_FORMAT_UINT2, cage.creaseEdges);
  add(RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT, RTC_FORMAT_FLOAT, cage.creaseSharpness);
  add(RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX, RTC_FORMAT_UINT, cage.cornerVertices);
  add(RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT, RTC_FORMAT_FLOAT, cage.cornerSharpness);
  add(RTC_BUFFER_TYPE_HOLE, RTC_FORMAT_UINT, cage.holes);
}

void SharedTopology::setVertices(RTCGeometry geometry, unsigned step, const Placement& placement,
                                 const std::vector<Vec3f>& positions, const std::vector<Vec3f>* shape) const {
  /* Embree reads 16 bytes per vertex and requires all four floats to be valid, so allocate one more vertex. */
  const size_t n = positions.size();
  const BufferHandle vertices(rtcNewBuffer(device.handle(), (n + 1) * sizeof(Vec3f)));
  device.check("allocating the vertices of a cage");
  auto* out = static_cast<Vec3f*>(rtcGetBufferData(vertices.get()));
  for (size_t i = 0; i < n; i++) out[i] = placement.apply(Model::positionInShape(positions[i], shape, cage, i));
  out[n] = Vec3f();
  rtcSetGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, vertices.get(), 0, sizeof(Vec3f), n);
}

GeometryHandle SharedTopology::makeGeometry(const Placement& placement, DisplacementContext& context,
                                            const RTCCompressionArguments* compression,
                                            const std::vector<Vec3f>* shape) const {
  GeometryHandle handle(rtcNewGeometry(device.handle(), RTC_GEOMETRY_TYPE_SUBDIVISION));
  device.check("creating a geometry");
  const RTCGeometry geometry = handle.get();
  rtcSetGeometryTimeStepCount(geometry, unsigned(1 + poses.size()));
  setVertices(geometry, 0, placement, cage.positions, shape);
  for (size_t i = 0; i < poses.size(); i++) setVertices(geometry, unsigned(1 + i), placement, poses[i], shape);
  for (const Buffer& b : buffers)
    rtcSetGeometryBuffer(geometry, b.type, 0, b.format, b.handle.get(), 0, b.stride, b.count);
  context.placement = placement;
  rtcSetGeometrySubdivisionMode(geometry, 0, subdivisionMode(cage.boundary));
  rtcSetGeometryTessellationRate(geometry, float(1 << context.level));
  if (context.rates) {
    const std::vector<float>& rates = context.copy->rates;
    std::copy(rates.begin(), rates.end(),
              newBuffer<float>(device, geometry, RTC_BUFFER_TYPE_LEVEL, RTC_FORMAT_FLOAT, rates.size(),
                               "allocating rates of edges"));
  }
  rtcSetGeometryUserData(geometry, &context);
  rtcSetGeometryDisplacementFunction(geometry, displace);
  if (compression) rtcSetGeometryCompression(geometry, compression);
  rtcCommitGeometry(geometry);
  device.check("committing the subdivision geometry");
  return handle;
}

} // namespace programs
