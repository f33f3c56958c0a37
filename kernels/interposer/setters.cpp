// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Overrides Embree's functions that create and release buffers, set properties of a geometry or commit it. Each calls
 * Embree and updates the Substituted, if there is one. Interpolation and half-edges need no overrides, because the
 * application's handles are Embree's. */

#include "devices.h"
#include "guarded.h"
#include "immortal.h"
#include "objects.h"

using namespace interposer;

namespace {

Substituted* find(RTCGeometry geometry) {
  return isActive() && geometry ? Objects::get().findSubstituted(geometry) : nullptr;
}

void changeInput(RTCGeometry geometry) {
  if (Substituted* const substituted = find(geometry)) substituted->change(Substituted::InputChange);
}

template<typename Set>
void changeInput(RTCGeometry geometry, const Set& set) {
  Substituted* const substituted = find(geometry);
  if (!substituted) return;
  set(substituted->input);
  substituted->change(Substituted::InputChange);
}

template<typename Set>
void changeAppearance(RTCGeometry geometry, const Set& set) {
  Substituted* const substituted = find(geometry);
  if (!substituted) return;
  set(*substituted);
  substituted->change(Substituted::AppearanceChange);
}

/* Never destroyed, because programs release buffers in destructors of static objects. */
Handles<BufferSize>& bufferSizes() { return immortal<Handles<BufferSize>>(); }

/* Returns the buffer, or NULL if memory runs out. device: of the buffer. */
RTCBuffer recorded(RTCBuffer buffer, RTCDevice device, size_t bytes) {
  if (!buffer || !isActive()) return buffer;
  const bool requiresWholeStrides = REAL(rtcGetDeviceProperty)(device, RTC_DEVICE_PROPERTY_VERSION) >= 40400;
  if (guarded("rtcNewBuffer", [&] { bufferSizes().add(buffer, {bytes, requiresWholeStrides}); })) return buffer;
  REAL(rtcReleaseBuffer)(buffer);
  return nullptr;
}

size_t sizeOf(RTCFormat format) {
  switch (format) {
  case RTC_FORMAT_UINT2: return 8;
  case RTC_FORMAT_UINT3:
  case RTC_FORMAT_FLOAT3: return 12;
  case RTC_FORMAT_UINT4: return 16;
  case RTC_FORMAT_GRID: return sizeof(RTCGrid);
  default: return 4; // the other formats of inputs have items of 4 bytes
  }
}

bool isOutOfBounds(RTCBuffer buffer, RTCFormat format, size_t offset, size_t stride, size_t count) {
  return bufferSizes().propertiesOf(buffer).isExceededBy(offset, stride, sizeOf(format), count);
}

/* Repeats Embree's checks of slot, format, alignment and size. Also false if the buffer is no input of a build. */
bool isAccepted(const Input& input, RTCBufferType type, unsigned int slot, const Buffer& buffer) {
  const RTCFormat format = buffer.format;
  const bool isCage = input.type == RTC_GEOMETRY_TYPE_SUBDIVISION;
  if (size_t(buffer.data) % 4 != 0 || buffer.stride % 4 != 0 || buffer.count > 0xFFFFFFFFu) return false;
  if (type == RTC_BUFFER_TYPE_VERTEX && !isCage && buffer.stride * buffer.count > size_t(16) << 30) return false;
  switch (type) {
  case RTC_BUFFER_TYPE_VERTEX: return format == RTC_FORMAT_FLOAT3 && slot < input.numTimeSteps;
  case RTC_BUFFER_TYPE_INDEX:
    if (input.type == RTC_GEOMETRY_TYPE_QUAD) return format == RTC_FORMAT_UINT4 && slot == 0;
    if (input.type == RTC_GEOMETRY_TYPE_TRIANGLE) return format == RTC_FORMAT_UINT3 && slot == 0;
    return isCage && format == RTC_FORMAT_UINT && slot == 0;
  case RTC_BUFFER_TYPE_GRID: return input.type == RTC_GEOMETRY_TYPE_GRID && format == RTC_FORMAT_GRID && slot == 0;
  case RTC_BUFFER_TYPE_EDGE_CREASE_INDEX: return isCage && format == RTC_FORMAT_UINT2 && slot == 0;
  case RTC_BUFFER_TYPE_LEVEL:
  case RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT:
  case RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT: return isCage && format == RTC_FORMAT_FLOAT && slot == 0;
  case RTC_BUFFER_TYPE_FACE:
  case RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX:
  case RTC_BUFFER_TYPE_HOLE: return isCage && format == RTC_FORMAT_UINT && slot == 0;
  default: return false;
  }
}

void setBuffer(RTCGeometry geometry, RTCBufferType type, unsigned int slot, const Buffer& buffer) {
  if (!isActive() || !geometry) return;
  Objects::get().setArrayBuffer(geometry, type, slot, buffer);
  changeInput(geometry, [&](Input& input) {
    if (!isAccepted(input, type, slot, buffer)) return;
    /* Embree keeps the previous buffer if it rejects this one, for example from another device. If data is NULL, it
     * allocates a buffer. */
    if (buffer.data && REAL(rtcGetGeometryBufferData)(geometry, type, slot) != buffer.data) return;
    input.isIncomplete |= !guarded("setting a buffer", [&] { input.buffers[{type, slot}] = buffer; });
  });
}

} // namespace

/* --- buffers -------------------------------------------------------------------------------- */

RTC_API RTCBuffer rtcNewBuffer(RTCDevice device, size_t byteSize) {
  return recorded(REAL(rtcNewBuffer)(device, byteSize), device, byteSize);
}

RTC_API RTCBuffer rtcNewSharedBuffer(RTCDevice device, void* ptr, size_t byteSize) {
  return recorded(REAL(rtcNewSharedBuffer)(device, ptr, byteSize), device, byteSize);
}

RTC_API void rtcRetainBuffer(RTCBuffer buffer) {
  REAL(rtcRetainBuffer)(buffer);
  if (isActive()) bufferSizes().retain(buffer);
}

RTC_API void rtcReleaseBuffer(RTCBuffer buffer) {
  if (isActive()) bufferSizes().release(buffer);
  REAL(rtcReleaseBuffer)(buffer);
}

RTC_API void rtcSetGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned int slot, RTCFormat format,
                                  RTCBuffer buffer, size_t byteOffset, size_t byteStride, size_t itemCount) {
  REAL(rtcSetGeometryBuffer)(geometry, type, slot, format, buffer, byteOffset, byteStride, itemCount);
  if (isActive() && geometry && buffer && Objects::get().find(geometry))
    setBuffer(geometry, type, slot,
              {format, (const char*)REAL(rtcGetBufferData)(buffer) + byteOffset, byteStride, itemCount,
               isOutOfBounds(buffer, format, byteOffset, byteStride, itemCount)});
}

RTC_API void rtcSetSharedGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned int slot, RTCFormat format,
                                        const void* ptr, size_t byteOffset, size_t byteStride, size_t itemCount) {
  REAL(rtcSetSharedGeometryBuffer)(geometry, type, slot, format, ptr, byteOffset, byteStride, itemCount);
  setBuffer(geometry, type, slot, {format, (const char*)ptr + byteOffset, byteStride, itemCount});
}

RTC_API void* rtcSetNewGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned int slot, RTCFormat format,
                                      size_t byteStride, size_t itemCount) {
  void* const data = REAL(rtcSetNewGeometryBuffer)(geometry, type, slot, format, byteStride, itemCount);
  if (data) setBuffer(geometry, type, slot, {format, (const char*)data, byteStride, itemCount});
  return data;
}

/* Functions of Embree 4.4, defined for all versions, because one library works with all of them. On CPUs, the memory of
 * the device is the memory of the host. */

RTC_API RTCBuffer rtcNewBufferHostDevice(RTCDevice device, size_t byteSize) {
  return recorded(REAL(rtcNewBufferHostDevice)(device, byteSize), device, byteSize);
}

RTC_API RTCBuffer rtcNewSharedBufferHostDevice(RTCDevice device, void* ptr, size_t byteSize) {
  return recorded(REAL(rtcNewSharedBufferHostDevice)(device, ptr, byteSize), device, byteSize);
}

RTC_API void rtcSetSharedGeometryBufferHostDevice(RTCGeometry geometry, RTCBufferType type, unsigned int slot,
                                                  RTCFormat format, const void* ptr, const void* dptr,
                                                  size_t byteOffset, size_t byteStride, size_t itemCount) {
  REAL(rtcSetSharedGeometryBufferHostDevice)(geometry, type, slot, format, ptr, dptr, byteOffset, byteStride,
                                             itemCount);
  setBuffer(geometry, type, slot, {format, (const char*)ptr + byteOffset, byteStride, itemCount});
}

RTC_API void rtcSetNewGeometryBufferHostDevice(RTCGeometry geometry, RTCBufferType type, unsigned int slot,
                                               RTCFormat format, size_t byteStride, size_t itemCount, void** ptr,
                                               void** dptr) {
  void* data = nullptr;
  REAL(rtcSetNewGeometryBufferHostDevice)(geometry, type, slot, format, byteStride, itemCount, &data, dptr);
  if (!data) return;
  if (ptr) *ptr = data;
  setBuffer(geometry, type, slot, {format, (const char*)data, byteStride, itemCount});
}

RTC_API void rtcUpdateGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned int slot) {
  REAL(rtcUpdateGeometryBuffer)(geometry, type, slot);
  changeInput(geometry);
}

/* --- shape ----------------------------------------------------------------------------------- */

RTC_API void rtcSetGeometryTimeStepCount(RTCGeometry geometry, unsigned int timeStepCount) {
  REAL(rtcSetGeometryTimeStepCount)(geometry, timeStepCount);
  changeInput(geometry, [&](Input& input) {
    if (timeStepCount > RTC_MAX_TIME_STEP_COUNT) return;
    for (unsigned int i = timeStepCount; i < input.numTimeSteps; i++) input.buffers.erase({RTC_BUFFER_TYPE_VERTEX, i});
    input.numTimeSteps = timeStepCount;
  });
}

RTC_API void rtcSetGeometryTimeRange(RTCGeometry geometry, float startTime, float endTime) {
  REAL(rtcSetGeometryTimeRange)(geometry, startTime, endTime);
  if (startTime > endTime) return; // Embree keeps the previous range
  changeInput(geometry, [&](Input& input) {
    input.startTime = startTime;
    input.endTime = endTime;
  });
}

RTC_API void rtcSetGeometryTessellationRate(RTCGeometry geometry, float tessellationRate) {
  REAL(rtcSetGeometryTessellationRate)(geometry, tessellationRate);
  changeInput(geometry, [&](Input& input) { input.tessellationRate = tessellationRate; });
}

RTC_API void rtcSetGeometrySubdivisionMode(RTCGeometry geometry, unsigned int topologyID, RTCSubdivisionMode mode) {
  REAL(rtcSetGeometrySubdivisionMode)(geometry, topologyID, mode);
  if (topologyID == 0) changeInput(geometry, [&](Input& input) { input.mode = mode; });
}

RTC_API void rtcSetGeometryDisplacementFunction(RTCGeometry geometry, RTCDisplacementFunctionN displacement) {
  REAL(rtcSetGeometryDisplacementFunction)(geometry, displacement);
  changeInput(geometry, [&](Input& input) { input.displacement = displacement; });
}

RTC_API void rtcSetGeometryBuildQuality(RTCGeometry geometry, RTCBuildQuality quality) {
  REAL(rtcSetGeometryBuildQuality)(geometry, quality);
  changeInput(geometry, [&](Input& input) { input.isRefitted = quality == RTC_BUILD_QUALITY_REFIT; });
}

RTC_API void rtcCommitGeometry(RTCGeometry geometry) {
  REAL(rtcCommitGeometry)(geometry);
  if (!isActive() || !geometry) return;
  Objects::get().commitArray(geometry);
  if (Substituted* const substituted = find(geometry)) substituted->commit();
}

/* --- appearance to rays ----------------------------------------------------------------------- */

RTC_API void rtcEnableGeometry(RTCGeometry geometry) {
  REAL(rtcEnableGeometry)(geometry);
  Substituted* const substituted = find(geometry);
  if (!substituted) return;
  REAL(rtcEnableGeometry)(substituted->substitute);
  substituted->setEnabled(true);
}

RTC_API void rtcDisableGeometry(RTCGeometry geometry) {
  REAL(rtcDisableGeometry)(geometry);
  Substituted* const substituted = find(geometry);
  if (!substituted) return;
  REAL(rtcDisableGeometry)(substituted->substitute);
  substituted->setEnabled(false);
}

RTC_API void rtcSetGeometryMask(RTCGeometry geometry, unsigned int mask) {
  REAL(rtcSetGeometryMask)(geometry, mask);
  changeAppearance(geometry, [&](Substituted& changed) { REAL(rtcSetGeometryMask)(changed.substitute, mask); });
}

RTC_API void rtcSetGeometryUserData(RTCGeometry geometry, void* ptr) {
  REAL(rtcSetGeometryUserData)(geometry, ptr);
  if (Substituted* const substituted = find(geometry)) substituted->setUserData(ptr);
}

RTC_API void rtcSetGeometryIntersectFilterFunction(RTCGeometry geometry, RTCFilterFunctionN filter) {
  REAL(rtcSetGeometryIntersectFilterFunction)(geometry, filter);
  changeAppearance(geometry, [&](Substituted& changed) { changed.data->intersectFilter = filter; });
}

RTC_API void rtcSetGeometryOccludedFilterFunction(RTCGeometry geometry, RTCFilterFunctionN filter) {
  REAL(rtcSetGeometryOccludedFilterFunction)(geometry, filter);
  changeAppearance(geometry, [&](Substituted& changed) { changed.data->occludedFilter = filter; });
}

RTC_API void rtcSetGeometryPointQueryFunction(RTCGeometry geometry, RTCPointQueryFunction pointQuery) {
  REAL(rtcSetGeometryPointQueryFunction)(geometry, pointQuery);
  changeAppearance(geometry, [&](Substituted& changed) { changed.data->pointQuery = pointQuery; });
}

RTC_API void rtcSetGeometryEnableFilterFunctionFromArguments(RTCGeometry geometry, bool enable) {
  REAL(rtcSetGeometryEnableFilterFunctionFromArguments)(geometry, enable);
  changeAppearance(geometry, [&](Substituted& changed) { changed.data->usesArgumentFilter = enable; });
}
