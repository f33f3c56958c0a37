// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "objects.h"

#include <cstring>

namespace interposer {

typedef std::lock_guard<std::mutex> Lock;

void Objects::addScene(RTCScene scene) {
  std::unique_ptr<Scene> added(new Scene);
  added->handle = scene;
  const Lock lock(mutex);
  scenes[scene] = std::move(added);
}

void Objects::addGeometry(RTCGeometry geometry, RTCGeometryType type, std::unique_ptr<Substituted> substituted) {
  std::unique_ptr<Geometry> added(new Geometry); // destroyed after the lock if the map runs out of memory
  added->handle = geometry;
  added->type = type;
  added->substituted = std::move(substituted);
  const Lock lock(mutex);
  geometries[geometry] = std::move(added);
}

template<typename Map>
static auto findOrNull(const Map& map, typename Map::key_type handle) {
  const auto found = map.find(handle);
  return found == map.end() ? nullptr : found->second.get();
}

Scene* Objects::find(RTCScene scene) {
  const Lock lock(mutex);
  return findOrNull(scenes, scene);
}

Geometry* Objects::find(RTCGeometry geometry) {
  const Lock lock(mutex);
  return findOrNull(geometries, geometry);
}

Substituted* Objects::findSubstituted(RTCGeometry geometry) {
  Geometry* const found = find(geometry);
  return found ? found->substituted.get() : nullptr;
}

void Objects::retain(RTCScene scene) {
  const Lock lock(mutex);
  if (Scene* const found = findOrNull(scenes, scene)) found->references++;
}

void Objects::retain(RTCGeometry geometry) {
  const Lock lock(mutex);
  if (Geometry* const found = findOrNull(geometries, geometry)) found->references++;
}

void Objects::release(Geometry* geometry, Garbage& garbage) {
  if (--geometry->references > 0) return;
  garbage.geometries.insert(geometries.extract(geometry->handle));
  release(geometry->instanced.only, garbage);
  for (Scene* const scene : geometry->instanced.all) release(scene, garbage);
}

void Objects::release(Scene* scene, Garbage& garbage) {
  if (!scene || --scene->references > 0) return;
  garbage.scenes.insert(scenes.extract(scene->handle));
  for (const auto& attached : scene->attachments) release(attached.second.geometry, garbage);
}

Objects::Garbage Objects::release(RTCScene scene) {
  const Lock lock(mutex);
  Garbage garbage;
  if (Scene* const found = findOrNull(scenes, scene)) release(found, garbage);
  return garbage;
}

Objects::Garbage Objects::release(RTCGeometry geometry) {
  const Lock lock(mutex);
  Garbage garbage;
  if (Geometry* const found = findOrNull(geometries, geometry)) release(found, garbage);
  return garbage;
}

void Objects::attach(RTCScene scene, unsigned int geomID, RTCGeometry geometry, bool isOriginal) {
  const Lock lock(mutex);
  Scene* const target = findOrNull(scenes, scene);
  Geometry* const attached = findOrNull(geometries, geometry);
  if (!target || !attached || !target->attachments.insert({geomID, {attached, isOriginal}}).second) return;
  attached->references++;
}

Objects::Garbage Objects::detach(RTCScene scene, unsigned int geomID) {
  const Lock lock(mutex);
  Garbage garbage;
  Scene* const from = findOrNull(scenes, scene);
  if (!from) return garbage;
  const auto attached = from->attachments.find(geomID);
  if (attached == from->attachments.end()) return garbage;
  Geometry* const geometry = attached->second.geometry;
  from->attachments.erase(attached);
  release(geometry, garbage);
  return garbage;
}

/* --- instances ----------------------------------------------------------------------------- */

const Scene* InstancedScenes::find(unsigned int instPrimID) const {
  if (only || instPrimID >= indices.count) return only;
  unsigned int index;
  std::memcpy(&index, indices.data + instPrimID * indices.stride, sizeof(index));
  return index < all.size() ? all[index] : nullptr; // RTC_INVALID_GEOMETRY_ID: the instance has no scene
}

Scene* Objects::findAndRetain(RTCScene scene) {
  Scene* const found = findOrNull(scenes, scene);
  if (found) found->references++;
  return found;
}

Geometry* Objects::findArray(RTCGeometry geometry) {
  Geometry* const found = findOrNull(geometries, geometry);
  return found && found->type == RTC_GEOMETRY_TYPE_INSTANCE_ARRAY ? found : nullptr;
}

Objects::Garbage Objects::setInstancedScene(RTCGeometry geometry, RTCScene scene) {
  const Lock lock(mutex);
  Garbage garbage;
  Geometry* const instance = findOrNull(geometries, geometry);
  if (!instance || instance->substituted || !scene) return garbage;
  Scene* const previous = instance->instanced.only;
  instance->instanced.only = findAndRetain(scene);
  release(previous, garbage);
  return garbage;
}

Objects::Garbage Objects::setInstancedScenes(RTCGeometry geometry, const RTCScene* instanced, size_t count,
                                             std::vector<Scene*>& storage) {
  const Lock lock(mutex);
  Garbage garbage;
  Geometry* const array = findArray(geometry);
  if (!array || !instanced) return garbage;
  for (size_t i = 0; i < count; i++) storage[i] = findAndRetain(instanced[i]);
  storage.swap(array->instanced.all);
  for (Scene* const scene : storage) release(scene, garbage);
  return garbage;
}

static bool isTransform(RTCFormat format) {
  return format == RTC_FORMAT_FLOAT3X4_ROW_MAJOR || format == RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR ||
         format == RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR || format == RTC_FORMAT_QUATERNION_DECOMPOSITION;
}

void Objects::setArrayBuffer(RTCGeometry geometry, RTCBufferType type, unsigned int slot, const Buffer& buffer) {
  const Lock lock(mutex);
  Geometry* const array = findArray(geometry);
  if (!array || slot != 0 || (type != RTC_BUFFER_TYPE_INDEX && type != RTC_BUFFER_TYPE_TRANSFORM)) return;
  /* Embree has the new buffer, or still its previous one if it rejected the call. Both can have the same data. */
  const void* const data = REAL(rtcGetGeometryBufferData)(geometry, type, slot);
  const bool isAccepted = data == buffer.data && buffer.stride % 4 == 0 && !buffer.isOutOfBounds;
  InstancedScenes& instanced = array->instanced;
  if (type == RTC_BUFFER_TYPE_TRANSFORM) {
    if (isAccepted && isTransform(buffer.format)) instanced.numTransforms = buffer.count;
  } else if (isAccepted && buffer.format == RTC_FORMAT_UINT) instanced.indices = buffer;
  else if (data != instanced.indices.data) instanced.indices = Buffer(); // Embree no longer has the recorded buffer
}

void Objects::commitArray(RTCGeometry geometry) {
  const Lock lock(mutex);
  Geometry* const array = findArray(geometry);
  if (!array) return;
  /* Embree ignores the index of an array with a single instance. It keeps the scene if the array grows later. */
  InstancedScenes& instanced = array->instanced;
  if (instanced.only || instanced.numTransforms != 1 || instanced.all.empty() || !instanced.all[0]) return;
  instanced.only = instanced.all[0];
  instanced.only->references++;
}

/* --- substitutes in scenes -------------------------------------------------------------------- */

std::vector<std::pair<unsigned int, Geometry*>> Objects::retainSubstituted(Scene& scene) {
  const Lock lock(mutex);
  std::vector<std::pair<unsigned int, Geometry*>> all;
  all.reserve(scene.attachments.size());
  for (const auto& attached : scene.attachments)
    if (attached.second.geometry->substituted) {
      attached.second.geometry->references++;
      all.push_back({attached.first, attached.second.geometry});
    }
  return all;
}

Objects::Garbage Objects::releaseAll(const std::vector<std::pair<unsigned int, Geometry*>>& all) {
  const Lock lock(mutex);
  Garbage garbage;
  for (const auto& entry : all) release(entry.second, garbage);
  return garbage;
}

bool Objects::setIsOriginal(Scene& scene, unsigned int geomID, const Geometry* geometry, bool isOriginal) {
  const Lock lock(mutex);
  const auto attached = scene.attachments.find(geomID);
  if (attached == scene.attachments.end() || attached->second.geometry != geometry ||
      attached->second.isOriginal == isOriginal)
    return false;
  attached->second.isOriginal = isOriginal;
  return true;
}

const SubstituteData* Objects::findSubstitute(RTCScene scene, const RTCPointQueryContext& context,
                                              unsigned int firstLevel, unsigned int geomID) {
  const Lock lock(mutex);
  const Scene* inner = findOrNull(scenes, scene);
  for (unsigned int level = firstLevel; level < context.instStackSize && inner; level++) {
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
    const unsigned int instPrimID = context.instPrimID[level];
#else
    const unsigned int instPrimID = 0;
#endif
    const auto instance = inner->attachments.find(context.instID[level]);
    inner = instance == inner->attachments.end() ? nullptr : instance->second.geometry->instanced.find(instPrimID);
  }
  if (!inner) return nullptr;
  const auto attached = inner->attachments.find(geomID);
  const bool isSubstituted =
      attached != inner->attachments.end() && attached->second.geometry->substituted && !attached->second.isOriginal;
  return isSubstituted ? attached->second.geometry->substituted->data : nullptr;
}

} // namespace interposer
