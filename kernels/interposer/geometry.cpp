// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "geometry.h"
#include "options.h"

#include <exception>
#include <map>
#include <new>
#include <string>

namespace interposer {

namespace {

/* Thrown if the application's progress function cancels a build. */
struct Canceled {};

const char* nameOf(RTCGeometryType type) {
  return type == RTC_GEOMETRY_TYPE_SUBDIVISION ? "a subdivision surface"
         : type == RTC_GEOMETRY_TYPE_GRID      ? "a grid geometry"
         : type == RTC_GEOMETRY_TYPE_QUAD      ? "a quad mesh"
                                               : "a triangle mesh";
}

/* Returns a context of libembree_cbvh, which devices with the same settings share. It is never released. Throws
 * std::bad_alloc or Unsupported. */
CbvhContext contextOf(const std::string& settings) {
  static std::mutex& mutex = *new std::mutex;
  static std::map<std::string, CbvhContext>& contexts = *new std::map<std::string, CbvhContext>;
  const std::lock_guard<std::mutex> lock(mutex);
  const auto found = contexts.find(settings);
  if (found != contexts.end()) return found->second;
  CbvhContext context = nullptr;
  check(cbvhNewContext(settings.empty() ? nullptr : settings.c_str(), nullptr, nullptr, &context));
  contexts[settings] = context;
  return context;
}

} // namespace

std::unique_ptr<Substituted> Substituted::make(RTCDevice device, const std::string& settings, RTCGeometry original,
                                               RTCGeometryType type) {
  if (!REAL(rtcGetDeviceProperty)(device, RTC_DEVICE_PROPERTY_USER_GEOMETRY_SUPPORTED)) {
    warnOnce("all geometry is left to Embree, which was built without user geometry");
    return nullptr;
  }
  SubstituteData* const data = newSubstituteData();
  if (!data) {
    warnOnce("a geometry is left to Embree: out of memory, or too many geometries are compressed");
    return nullptr;
  }
  data->original = original;
  const RTCGeometry substitute = newUserGeometry(device, data);
  if (!substitute) {
    deleteSubstituteData(data);
    return nullptr;
  }
  try {
    std::unique_ptr<Substituted> made(new Substituted(settings, original, type, data, substitute));
    made->input.hasWideNodes = REAL(rtcGetDeviceProperty)(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0;
    return made;
  } catch (...) {
    REAL(rtcReleaseGeometry)(substitute);
    deleteSubstituteData(data);
    throw;
  }
}

Substituted::Substituted(const std::string& settings, RTCGeometry original, RTCGeometryType type, SubstituteData* data,
                         RTCGeometry substitute)
  : data(data),
    substitute(substitute),
    settings(settings) {
  input.type = type;
  input.original = original;
  data->hasPointQueries = type != RTC_GEOMETRY_TYPE_SUBDIVISION;
  input.userData = &data->userData;
  REAL(rtcRetainGeometry)(original);
}

Substituted::~Substituted() {
  discard();
  REAL(rtcReleaseGeometry)(substitute);
  REAL(rtcReleaseGeometry)(input.original);
  deleteSubstituteData(data);
}

void Substituted::discard() {
  if (data->group) cbvhReleaseGroup(data->group);
  if (surface) cbvhReleaseSurface(surface);
  data->group = nullptr;
  surface = nullptr;
}

void Substituted::setUserData(void* userData) {
  data->userData = userData;
  change(input.displacement ? InputChange : AppearanceChange);
}

/* A commit without changes means that shared buffers have new contents. */
void Substituted::commit() {
  if (changes != AppearanceChange) isCommitted = true;
  changes = 0;
  REAL(rtcCommitGeometry)(substitute);
}

bool Substituted::build(const Progress& progress) {
  const std::lock_guard<std::mutex> lock(building);
  if (!needsBuild()) return true;
  try {
    discard(); // frees the old surface before allocating the new one
    buildSurface(progress);
    isLeft = false;
  } catch (const Canceled&) {
    discard();
    return false;
  } catch (const Unsupported& reason) {
    discard();
    isLeft = true;
    reportLeftToEmbree(nameOf(input.type), reason.what());
  } catch (const std::exception&) { // std::bad_alloc, or std::length_error of a container
    discard();
    isLeft = true;
    warnOnce("%s is left to Embree: out of memory", nameOf(input.type));
  }
  REAL(rtcCommitGeometry)(substitute); // the bounds have changed
  isCommitted = false;
  return true;
}

void Substituted::buildSurface(const Progress& progress) {
  const CbvhContext context = contextOf(settings);
  check(cbvhNewSurface(context, &surface));
  if (options().maxError == 0) check(cbvhSetSurfaceLossless(surface, 1));
  if (options().maxError > 0) {
    CbvhAccuracy accuracy = CbvhAccuracy();
    accuracy.maxError = options().maxError;
    check(cbvhSetSurfaceAccuracy(surface, &accuracy));
  }
  input.applyTo(surface);
  const auto reportProgress = [](void* progress, double done) { return (*(const Progress*)progress)(done) ? 1 : 0; };
  const CbvhError error = cbvhCommitSurface(surface, reportProgress, (void*)&progress);
  if (error == CBVH_ERROR_CANCELLED) throw Canceled();
  check(error);
  CbvhGroup group = nullptr;
  check(cbvhNewGroup(context, &surface, 1, &group));
  /* CBVH_ERROR_INVALID_ARGUMENT: the group is committed, without invalid parts of the input */
  const CbvhError groupError = cbvhCommitGroup(group);
  if (groupError != CBVH_OK && groupError != CBVH_ERROR_INVALID_ARGUMENT) {
    cbvhReleaseGroup(group);
    check(groupError);
  }
  CbvhGroupStatistics statistics = CbvhGroupStatistics();
  const CbvhError statisticsError = cbvhGetGroupStatistics(group, &statistics);
  if (statisticsError != CBVH_OK) {
    cbvhReleaseGroup(group);
    check(statisticsError);
  }
  data->deviation = statistics.maxVertexDeviation;
  data->group = group;
}

} // namespace interposer
