// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The application's scenes and geometries, and their references. A substitute must exist while a scene contains its
 * geometry, but Embree does not report when that ends. References are therefore counted as Embree counts them: of the
 * application, of scenes to geometries, and of instances to scenes. */

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
  bool isOriginal;                  // Embree has the original, not the substitute
};

struct Scene
{
  RTCScene handle;
  size_t references = 1;
  std::map<unsigned int, Attachment> attached;
  RTCProgressMonitorFunction progress = nullptr;
  void* progressPtr = nullptr;
  std::mutex preparing;                  // held while a thread builds substitutes
  std::mutex joining;                    // protects the two members below
  size_t numJoined = 0;                  // threads in a commit
  bool isEnding = true;                  // a thread has left the commit
  std::atomic<bool> isCanceled{false};   // for all threads that joined the commit
};

class Objects
{
public:
  /* Never destroyed, because programs release geometries in destructors of static objects. */
  static Objects& get() { static Objects& objects = *new Objects; return objects; }

  void addScene(RTCScene scene);
  /* substituted: NULL for instances. */
  void addGeometry(RTCGeometry geometry, Substituted* substituted);

  /* NULL for unknown objects. Valid while the caller holds a reference to the handle. */
  Scene* find(RTCScene scene);
  Geometry* find(RTCGeometry geometry);
  Substituted* findSubstituted(RTCGeometry geometry);

  void retain(RTCScene scene);
  void retain(RTCGeometry geometry);

  /* Objects without references. Must be destroyed after the lock is released, and after Embree has released the object
   * that held them. */
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

  /* Retains the attached geometries with substitutes. The caller must pass the result to releaseAll. */
  std::vector<std::pair<unsigned int, Geometry*>> substitutedOf(Scene& scene);
  Garbage releaseAll(const std::vector<std::pair<unsigned int, Geometry*>>& all);
  /* True if Embree's scene has another geometry attached (original or substitute) than it should; records the
   * change. */
  bool exchange(Scene& scene, unsigned int geomID, const Geometry* geometry, bool isOriginal);

  /* True if a geometry has a substitute. geomID: in the scene that the instances lead to, from `scene`. instances: IDs,
   * outermost first. */
  bool isSubstituted(RTCScene scene, const unsigned int* instances, unsigned int numInstances, unsigned int geomID);

private:
  void release(Geometry* geometry, Garbage& garbage);
  void release(Scene* scene, Garbage& garbage);

  std::mutex mutex;
  std::unordered_map<RTCScene, Scene*> scenes;
  std::unordered_map<RTCGeometry, Geometry*> geometries;
};

} // namespace interposer
