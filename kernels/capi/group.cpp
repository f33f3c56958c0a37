// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "group.h"
#include "structs.h"

#include "cbvh/operations/compression.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

using namespace embree::capi;

namespace {

constexpr size_t maxPrimitive = 0xFFFFFFFFu; // primitive numbers have 32 bits

/* Converts an index, or CompressionStatistics::noPrimitive to CBVH_NONE. */
size_t sizeOf(unsigned int index) {
  return index == embree::cbvh::CompressionStatistics::noPrimitive ? CBVH_NONE : index;
}

/* Lets a new scene allocate everything that attaching geometries with the IDs 0 to count-1 needs. Embree loses an ID if
 * it runs out of memory while it attaches a geometry. */
void reserveGeometryIDs(const CbvhContextTy& context, RTCScene scene, size_t count) {
  const RTCGeometry placeholder = rtcNewGeometry(context.device, RTC_GEOMETRY_TYPE_SUBDIVISION);
  context.check();
  rtcAttachGeometryByID(scene, placeholder, unsigned(count - 1));
  Failure failure = context.takeError();
  if (!failure) {
    rtcDetachGeometry(scene, unsigned(count - 1));
    failure = context.takeError();
  }
  rtcReleaseGeometry(placeholder);
  if (failure) throw failure;
}

} // namespace

CbvhGroupTy::CbvhGroupTy(CbvhContext context, const CbvhSurface* from, size_t count)
  : context(context),
    scene(rtcNewScene(context->device)) {
  try {
    context->check(); // throws if there was no memory for the scene
    for (size_t i = 0; i < count; i++) surfaces.emplace_back(from[i]);
    firstPrimitive.resize(count + 1, 0);
    attached.resize(count, nullptr);
    isReported.resize(count, false);
    reserveGeometryIDs(*context, scene, count);
  } catch (...) {
    if (scene) rtcReleaseScene(scene);
    throw;
  }
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
}

CbvhGroupTy::~CbvhGroupTy() { rtcReleaseScene(scene); }

void CbvhGroupTy::commit() {
  for (const auto& surface : surfaces) surface->committedInput(); // throws before any mask is applied
  for (const auto& surface : surfaces) surface->applyMask();      // may throw, so it precedes all changes of the scene
  for (size_t i = 0; i < surfaces.size(); i++) {
    const RTCGeometry geometry = surfaces[i]->committedInput()->geometry;
    if (geometry == attached[i]) continue;
    if (attached[i]) {
      rtcDetachGeometry(scene, unsigned(i));
      context->check(); // without memory, the scene keeps the geometry, which rays of the last commit use
    }
    attached[i] = nullptr;
    rtcAttachGeometryByID(scene, geometry, unsigned(i)); // allocates nothing: the ID is reserved, or was just detached
    context->check();
    attached[i] = geometry;
    isReported[i] = false;
  }
  rtcCommitScene(scene);
  const Failure failure = context->takeError();
  isCommitted = false;
  std::fill(firstPrimitive.begin(), firstPrimitive.end(), 0);
  try {
    updateStatistics();
  } catch (...) {
    if (!failure) throw;
  }
  for (size_t i = 0; isCommitted && i < surfaces.size(); i++)
    firstPrimitive[i + 1] = firstPrimitive[i] + surfaces[i]->committedInput()->numPrimitives;
  if (failure) throw failure;
  size_t numUnsupportedFaces = 0;
  for (size_t i = 0; i < surfaces.size(); i++) {
    if (!isReported[i]) numUnsupportedFaces += embree::core::numUnsupportedFaces((embree::Geometry*)attached[i]);
    isReported[i] = true;
  }
  if (numUnsupportedFaces != 0)
    throw Failure{CBVH_ERROR_INVALID_ARGUMENT,
                  std::to_string(numUnsupportedFaces) +
                      " face(s) left out: expected at most 16 corners in them and in the faces at their vertices, and "
                      "at most 1024 "
                      "faces per vertex (1023 at a border, fewer if these have more than 4 corners)"};
}

/* Called after each commit, because a later call could fail: if the commit of another group changes a surface's mask,
 * statisticsOf() throws until this group is committed again. */
void CbvhGroupTy::updateStatistics() {
  const embree::cbvh::CompressionStatistics all = embree::core::statisticsOf((embree::Scene*)scene);
  statistics.bytes = all.allBytes();
  statistics.numQuads = all.numQuads + all.numUncompressedQuads;
  statistics.numMovingQuads = all.numMovingQuads;
  statistics.numInvalidQuads = all.numInvalidQuads;
  statistics.maxVertexDeviation = all.maxVertexDeviation;
  statistics.firstInvalidSurface = all.numInvalidQuads ? sizeOf(all.firstInvalidGeometry) : 0;
  statistics.firstInvalidPrimitive = all.numInvalidQuads ? sizeOf(all.firstInvalidPrimitive) : 0;
  isCommitted = wasCommitted = true;
}

CbvhError cbvhNewGroup(CbvhContext context, const CbvhSurface* surfaces, size_t count, CbvhGroup* group) {
  if (!context || !group) return rejectArgument("context or group is NULL");
  return guarded(context, [&] {
    require(count > 0 && surfaces, "there are no surfaces: expected at least 1");
    require(count < 0xFFFFFFFFu, "too many surfaces: expected fewer than 4294967295");
    for (size_t i = 0; i < count; i++) {
      if (!surfaces[i]) throwInvalidArgument("surface " + std::to_string(i) + " is NULL");
      if (surfaces[i]->context->device != context->device)
        throwInvalidArgument("surface " + std::to_string(i) + " belongs to another context");
      if (surfaces[i]->refersToGeometry())
        throwInvalidArgument("surface " + std::to_string(i) +
                             " refers to a geometry: expected a surface that cbvhNewSurface or a file created");
    }
    *group = new CbvhGroupTy(context, surfaces, count);
  });
}
void cbvhRetainGroup(CbvhGroup group) {
  if (group) group->retain();
}
void cbvhReleaseGroup(CbvhGroup group) {
  if (group) group->release();
}

CbvhError cbvhCommitGroup(CbvhGroup group) {
  if (!group) return rejectArgument("group is NULL");
  const RefPtr<CbvhGroupTy> held(group);
  return guarded(group->context.get(), [&] { group->commit(); });
}

size_t cbvhGetGroupSurfaceCount(CbvhGroup group) { return group ? group->surfaces.size() : 0; }
CbvhSurface cbvhGetGroupSurface(CbvhGroup group, size_t index) {
  return group && index < group->surfaces.size() ? group->surfaces[index].get() : nullptr;
}

void cbvhSetGroupUserPtr(CbvhGroup group, void* userPtr) {
  if (group) group->userPtr = userPtr;
}
void* cbvhGetGroupUserPtr(CbvhGroup group) { return group ? group->userPtr : nullptr; }

unsigned int cbvhGetGroupFirstPrimitive(CbvhGroup group, size_t index) {
  if (!group) {
    rejectArgument("group is NULL");
    return 0;
  }
  if (index >= group->firstPrimitive.size()) {
    char text[96];
    std::snprintf(text, sizeof(text), "invalid index %zu: expected 0 to %zu, the number of surfaces", index,
                  group->surfaces.size());
    rejectArgument(text);
    return 0;
  }
  return unsigned(std::min(group->firstPrimitive[index], maxPrimitive));
}

int cbvhFindGroupPrimitive(CbvhGroup group, unsigned int number, size_t* index, unsigned int* primID) {
  if (!group || !index || !primID) {
    rejectArgument("group, index or primID is NULL");
    return 0;
  }
  const std::vector<size_t>& first = group->firstPrimitive;
  const size_t i = size_t(std::upper_bound(first.begin(), first.end(), number) - first.begin()) - 1;
  if (i >= group->surfaces.size()) return 0;
  *index = i;
  *primID = unsigned(number - first[i]);
  return 1;
}

CbvhError cbvhCheckGeometry(CbvhGroup group, unsigned int flags, unsigned int known) {
  if (!group) return rejectArgument("group is NULL");
  return guarded(group->context.get(), [&] {
    checkFlags(flags, known, "geometry");
    if (group->firstPrimitive.back() >= maxPrimitive)
      throw Failure{CBVH_ERROR_INVALID_OPERATION, "too many primitives for a geometry: expected fewer than 4294967295"};
  });
}

void cbvhGetGroupBounds(CbvhGroup group, float lower[3], float upper[3]) {
  RTCBounds bounds = {INFINITY, INFINITY, INFINITY, 0, -INFINITY, -INFINITY, -INFINITY, 0};
  if (group) {
    const ErrorScope errors(group->context.get()); // without a commit, the bounds are empty
    rtcGetSceneBounds(group->scene, &bounds);
  }
  const float l[3] = {bounds.lower_x, bounds.lower_y, bounds.lower_z},
              u[3] = {bounds.upper_x, bounds.upper_y, bounds.upper_z};
  if (lower) std::copy(l, l + 3, lower);
  if (upper) std::copy(u, u + 3, upper);
}

CbvhError cbvhGetGroupStatistics(CbvhGroup group, CbvhGroupStatistics* statistics) {
  if (!group || !statistics) return rejectArgument("group or statistics is NULL");
  return guarded(group->context.get(), [&] {
    embree::core::requireStruct(statistics);
    if (!group->isCommitted)
      throw Failure{CBVH_ERROR_INVALID_OPERATION, "the group is not committed: call cbvhCommitGroup first"};
    embree::core::writeStruct(statistics, group->statistics);
  });
}
