// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The application's scenes and geometries. A substitute must exist while a scene contains its geometry, but Embree does
 * not report when a scene releases the geometry. This file therefore counts references as Embree does: references of
 * the application, of scenes to geometries, and of instances to scenes. */

#include "geometry.h"

#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

namespace interposer {

struct Scene;

/* A geometry with a substitute, or an instance. */
struct Geometry
{
  RTCGeometry handle;
  size_t references = 1;
  std::unique_ptr<Substituted> substituted;
  std::vector<Scene*> scenes;       // for an instance: the instanced scenes
};

struct Attachment
{
  Geometry* geometry;
  bool isOriginal;                  // Embree's scene contains the original, not the substitute
};

struct Scene
{
  RTCScene handle;
  size_t references = 1;
  std::map<unsigned int, Attachment> attached; // by geomID; only geometries that Objects contains
  RTCProgressMonitorFunction progress = nullptr; // the application's
  void* progressPtr = nullptr;
  std::mutex preparing;                  // held while a thread builds substitutes
  std::mutex joining;                    // protects the two members below
  size_t numJoined = 0;                  // threads in the current commit
  bool isEnding = true;                  // a thread has left it
  std::atomic<bool> isCanceled{false};   // for all threads that joined the commit
};

/* Thread-safe. Handles that Objects does not contain are ignored. */
class Objects
{
public:
  /* Never destroyed, because programs release geometries in destructors of static objects. */
  static Objects& get() { static Objects& objects = *new Objects; return objects; }

  void addScene(RTCScene scene);
  /* Takes ownership of `substituted`, which is NULL for instances. */
  void addGeometry(RTCGeometry geometry, Substituted* substituted);

  /* Return NULL for unknown objects. The result is valid while the caller holds a reference to the handle. */
  Scene* find(RTCScene scene);
  Geometry* find(RTCGeometry geometry);
  Substituted* findSubstituted(RTCGeometry geometry);

  void retain(RTCScene scene);
  void retain(RTCGeometry geometry);

  /* Objects without references. The caller must destroy them after Embree has released the object that referred to
   * them. Destroying them calls Embree, so Objects must not be locked then. */
  struct Garbage
  {
    std::vector<std::unique_ptr<Geometry>> geometries;
    std::vector<std::unique_ptr<Scene>> scenes;
  };
  Garbage release(RTCScene scene);
  Garbage release(RTCGeometry geometry);

  void attach(RTCScene scene, unsigned int geomID, RTCGeometry geometry, bool isOriginal);
  Garbage detach(RTCScene scene, unsigned int geomID);
  Garbage setInstanced(RTCGeometry geometry, const RTCScene* scenes, size_t count);

  /* Retains the attached geometries with substitutes, which the caller must pass to releaseAll. */
  std::vector<std::pair<unsigned int, Geometry*>> substitutedOf(Scene& scene);
  Garbage releaseAll(const std::vector<std::pair<unsigned int, Geometry*>>& all);
  /* Records whether Embree's scene must contain the original. Returns true if the caller must exchange it with the
   * substitute, or the reverse. */
  bool exchange(Scene& scene, unsigned int geomID, const Geometry* geometry, bool isOriginal);

  /* True if geomID is a substitute. instances: IDs of instances from `scene` to the scene with this geometry, outermost
   * first. */
  bool isSubstituted(RTCScene scene, const unsigned int* instances, unsigned int numInstances, unsigned int geomID);

private:
  void release(Geometry* geometry, Garbage& garbage);
  void release(Scene* scene, Garbage& garbage);

  std::mutex mutex;
  std::unordered_map<RTCScene, Scene*> scenes;
  std::unordered_map<RTCGeometry, Geometry*> geometries;
};

} // namespace interposer
