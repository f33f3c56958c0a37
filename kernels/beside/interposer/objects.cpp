// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "objects.h"

namespace interposer {

typedef std::lock_guard<std::mutex> Lock;

void Objects::addScene(RTCScene scene)
{
  const Lock lock(mutex);
  Scene* const added = new Scene;
  added->handle = scene;
  scenes[scene] = added;
}

void Objects::addGeometry(RTCGeometry geometry, Substituted* substituted)
{
  const Lock lock(mutex);
  Geometry* const added = new Geometry;
  added->handle = geometry;
  added->substituted.reset(substituted);
  geometries[geometry] = added;
}

template<typename Map>
static auto findOrNull(const Map& map, typename Map::key_type handle)
{
  const auto found = map.find(handle);
  return found == map.end() ? nullptr : found->second;
}

Scene* Objects::find(RTCScene scene)
{
  const Lock lock(mutex);
  return findOrNull(scenes, scene);
}

Geometry* Objects::find(RTCGeometry geometry)
{
  const Lock lock(mutex);
  return findOrNull(geometries, geometry);
}

Substituted* Objects::findSubstituted(RTCGeometry geometry)
{
  Geometry* const found = find(geometry);
  return found ? found->substituted.get() : nullptr;
}

void Objects::retain(RTCScene scene)
{
  const Lock lock(mutex);
  if (Scene* const found = findOrNull(scenes, scene)) found->references++;
}

void Objects::retain(RTCGeometry geometry)
{
  const Lock lock(mutex);
  if (Geometry* const found = findOrNull(geometries, geometry)) found->references++;
}

void Objects::release(Geometry* geometry, Garbage& garbage)
{
  if (--geometry->references > 0) return;
  geometries.erase(geometry->handle);
  garbage.geometries.emplace_back(geometry);
  for (Scene* const scene : geometry->scenes) release(scene, garbage);
}

void Objects::release(Scene* scene, Garbage& garbage)
{
  if (--scene->references > 0) return;
  scenes.erase(scene->handle);
  garbage.scenes.emplace_back(scene);
  for (const auto& attached : scene->attachments) release(attached.second.geometry, garbage);
}

Objects::Garbage Objects::release(RTCScene scene)
{
  const Lock lock(mutex);
  Garbage garbage;
  if (Scene* const found = findOrNull(scenes, scene)) release(found, garbage);
  return garbage;
}

Objects::Garbage Objects::release(RTCGeometry geometry)
{
  const Lock lock(mutex);
  Garbage garbage;
  if (Geometry* const found = findOrNull(geometries, geometry)) release(found, garbage);
  return garbage;
}

void Objects::attach(RTCScene scene, unsigned int geomID, RTCGeometry geometry, bool isOriginal)
{
  const Lock lock(mutex);
  Scene* const target = findOrNull(scenes, scene);
  Geometry* const attached = findOrNull(geometries, geometry);
  if (!target || !attached || !target->attachments.insert({geomID, {attached, isOriginal}}).second) return;
  attached->references++;
}

Objects::Garbage Objects::detach(RTCScene scene, unsigned int geomID)
{
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

Objects::Garbage Objects::setInstanced(RTCGeometry geometry, const RTCScene* instanced, size_t count)
{
  const Lock lock(mutex);
  Garbage garbage;
  Geometry* const instance = findOrNull(geometries, geometry);
  if (!instance) return garbage;
  std::vector<Scene*> previous;
  previous.swap(instance->scenes);
  for (size_t i = 0; i < count; i++)
    if (Scene* const scene = findOrNull(scenes, instanced[i])) {
      scene->references++;
      instance->scenes.push_back(scene);
    }
  for (Scene* const scene : previous) release(scene, garbage);
  return garbage;
}

std::vector<std::pair<unsigned int, Geometry*>> Objects::retainSubstituted(Scene& scene)
{
  const Lock lock(mutex);
  std::vector<std::pair<unsigned int, Geometry*>> all;
  for (const auto& attached : scene.attachments)
    if (attached.second.geometry->substituted) {
      attached.second.geometry->references++;
      all.push_back({attached.first, attached.second.geometry});
    }
  return all;
}

Objects::Garbage Objects::releaseAll(const std::vector<std::pair<unsigned int, Geometry*>>& all)
{
  const Lock lock(mutex);
  Garbage garbage;
  for (const auto& entry : all) release(entry.second, garbage);
  return garbage;
}

bool Objects::setIsOriginal(Scene& scene, unsigned int geomID, const Geometry* geometry, bool isOriginal)
{
  const Lock lock(mutex);
  const auto attached = scene.attachments.find(geomID);
  if (attached == scene.attachments.end() || attached->second.geometry != geometry
    || attached->second.isOriginal == isOriginal) return false;
  attached->second.isOriginal = isOriginal;
  return true;
}

bool Objects::isSubstituted(RTCScene scene, const unsigned int* instances, unsigned int numInstances,
  unsigned int geomID)
{
  const Lock lock(mutex);
  const Scene* inner = findOrNull(scenes, scene);
  for (unsigned int level = 0; level < numInstances && inner; level++) {
    const auto instance = inner->attachments.find(instances[level]);
    inner = instance == inner->attachments.end()
      || instance->second.geometry->scenes.empty() ? nullptr : instance->second.geometry->scenes[0];
  }
  if (!inner) return false;
  const auto attached = inner->attachments.find(geomID);
  return attached != inner->attachments.end() && attached->second.geometry->substituted && !attached->second.isOriginal;
}

} // namespace interposer
