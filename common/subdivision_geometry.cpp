// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "subdivision_geometry.h"

#include <algorithm>
#include <cstring>

namespace cbvh {
namespace {

void displace(const RTCDisplacementFunctionNArguments* args)
{
  const DisplacementContext& context = *static_cast<const DisplacementContext*>(args->geometryUserPtr);
  constexpr size_t batch = 256;
  float offsets[batch];
  for (size_t begin = 0; begin < args->N; begin += batch)
  {
    const size_t n = std::min<size_t>(batch, args->N - begin);
    if (context.displacement)
      context.displacement->offsets(args->primID, n, args->u + begin, args->v + begin, offsets);
    else
      std::fill(offsets, offsets + n, 0.0f);
    for (size_t i = 0; i < n; i++)
    {
      args->P_x[begin + i] += offsets[i] * args->Ng_x[begin + i];
      args->P_y[begin + i] += offsets[i] * args->Ng_y[begin + i];
      args->P_z[begin + i] += offsets[i] * args->Ng_z[begin + i];
    }
  }
  if (!context.captured)
    return;
  for (size_t i = 0; i < args->N; i++)
  {
    float u = args->u[i], v = args->v[i];
    const Patch& patch = context.layout->find(args->primID, u, v);
    if (!context.layout->isQuadFace(args->primID))
      decodeSubPatch(u, v);
    const size_t x = size_t(std::lround(u * float(patch.resolution)));
    const size_t y = size_t(std::lround(v * float(patch.resolution)));
    float* out = context.captured + 3 * (patch.firstVertex + y * (patch.resolution + 1) + x);
    out[0] = args->P_x[i];
    out[1] = args->P_y[i];
    out[2] = args->P_z[i];
  }
}

template<typename T>
void copyBuffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, const T* data, size_t count)
{
  if (void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count))
    std::memcpy(buffer, data, sizeof(T) * count);
}

template<typename T>
void copyBuffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, const std::vector<T>& data)
{
  if (!data.empty())
    copyBuffer(geometry, type, format, data.data(), data.size());
}

RTCSubdivisionMode subdivisionMode(BoundaryRule rule)
{
  switch (rule)
  {
  case BoundaryRule::None: return RTC_SUBDIVISION_MODE_NO_BOUNDARY;
  case BoundaryRule::EdgeAndCorner: return RTC_SUBDIVISION_MODE_PIN_CORNERS;
  default: return RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY;
  }
}

} // namespace

GeometryHandle makeSubdivisionGeometry(EmbreeDevice& device, const Cage& cage, int level, DisplacementContext& context)
{
  GeometryHandle handle(rtcNewGeometry(device.handle(), RTC_GEOMETRY_TYPE_SUBDIVISION));
  device.check("making a geometry");
  const RTCGeometry geometry = handle.get();
  copyBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, cage.positions);
  copyBuffer(geometry, RTC_BUFFER_TYPE_FACE, RTC_FORMAT_UINT, cage.faceSizes);
  copyBuffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, cage.faceIndices);
  copyBuffer(geometry, RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, RTC_FORMAT_UINT2, cage.creaseEdges);
  copyBuffer(geometry, RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT, RTC_FORMAT_FLOAT, cage.creaseSharpness);
  copyBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX, RTC_FORMAT_UINT, cage.cornerVertices);
  copyBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT, RTC_FORMAT_FLOAT, cage.cornerSharpness);
  copyBuffer(geometry, RTC_BUFFER_TYPE_HOLE, RTC_FORMAT_UINT, cage.holes);
  rtcSetGeometrySubdivisionMode(geometry, 0, subdivisionMode(cage.boundary));
  rtcSetGeometryTessellationRate(geometry, float(1 << level));
  rtcSetGeometryUserData(geometry, &context);
  rtcSetGeometryDisplacementFunction(geometry, displace);
  rtcCommitGeometry(geometry);
  device.check("committing the subdivision geometry");
  return handle;
}

} // namespace cbvh
