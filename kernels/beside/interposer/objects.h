// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Which scenes and geometries there are, and who holds whom: what stands in for a geometry stays as long as a scene has it, which Embree tells nobody. So
 * references are counted here as Embree counts them: those of the application, of scenes to geometries, and of instances to scenes. */

#include "geometry.h"

#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

namespace interposer {

struct Scene;

/* One that is substituted, or an instance. */
struct Geometry
{
  RTCGeometry handle;
  size_t references = 1;
  std::unique_ptr<Substituted> substituted;
  std::vector<Scene*> scenes;       // of instances
};

struct Attachment
{
  Geometry* geometry;
  bool isOriginal;                  // Embree has the original, not what stands in for it
};

struct Scene
{
  RTCScene handle;
  size_t references = 1;
  std::map<unsigned int, Attachment> attached;
  RTCProgressMonitorFunction progress = nullptr;
  void* progressPtr = nullptr;
  std::mutex preparing;
  std::mutex joining;
  size_t numJoined = 0;                  // threads in a commit; guarded by joining
  bool isEnding = true;                  // a thread has left the commit; guarded by joining
  std::atomic<bool> isCancelled{false};  // the commit, for all threads that have joined it
};

class Objects
{
public:
  /* never destroyed: programs release geometry when their statics end */
  static Objects& get() { static Objects& objects = *new Objects; return objects; }

  void addScene(RTCScene scene);
  /* substituted: or NULL of instances */
  void addGeometry(RTCGeometry geometry, Substituted* substituted);

  /* NULL where we do not know it. What is found stays while the caller's own reference does. */
  Scene* find(RTCScene scene);
  Geometry* find(RTCGeometry geometry);
  Substituted* findSubstituted(RTCGeometry geometry);

  void retain(RTCScene scene);
  void retain(RTCGeometry geometry);

  /* What nobody holds any more. It is to be destroyed after the lock is let go, and after Embree has let go of what held it. */
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

  /* Attachments of what is substituted, retained: to be released by releaseAll. */
  std::vector<std::pair<unsigned int, Geometry*>> substitutedOf(Scene& scene);
  Garbage releaseAll(const std::vector<std::pair<unsigned int, Geometry*>>& all);
  /* Whether Embree's scene has it in another way than it is to; says of it that it has no longer. */
  bool exchange(Scene& scene, unsigned int geomID, const Geometry* geometry, bool isOriginal);

  /* Whether a geometry of what the instances lead to from a scene, the outermost first, is one that another stands for there. */
  bool isSubstituted(RTCScene scene, const unsigned int* instances, unsigned int numInstances, unsigned int geomID);

private:
  void release(Geometry* geometry, Garbage& garbage);
  void release(Scene* scene, Garbage& garbage);

  std::mutex mutex;
  std::unordered_map<RTCScene, Scene*> scenes;
  std::unordered_map<RTCGeometry, Geometry*> geometries;
};

} // namespace interposer
