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
  std::map<unsigned int, Attachment> attachments; // by geomID; only geometries that Objects contains
  RTCProgressMonitorFunction progress = nullptr; // the application's
  void* progressPtr = nullptr;
  std::mutex prepareMutex;               // held while a thread builds substitutes
  std::mutex commitMutex;                // protects the two members below
  size_t numCommitting = 0;              // threads in rtcCommitScene or rtcJoinCommitScene
  bool startsNewCommit = true;           // the next thread starts a new commit: a thread has left the current one
  std::atomic<bool> isCanceled{false};   // for all threads that joined the current commit
  std::atomic<bool> hasBuilt{false};     // the current commit has built substitutes
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

  /* Objects without references, including the released object itself. The caller must keep them until Embree has
   * released that object. Destroying them calls Embree, so Objects must not be locked then. */
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

  /* Retains and returns the attached geometries that have substitutes, with their geomIDs. The caller must pass the
   * result to releaseAll. */
  std::vector<std::pair<unsigned int, Geometry*>> retainSubstituted(Scene& scene);
  Garbage releaseAll(const std::vector<std::pair<unsigned int, Geometry*>>& all);
  /* Records whether Embree's scene must contain the original or the substitute. Returns true if the caller must replace
   * one by the other, and false if nothing changes, or if another thread has detached the geometry. */
  bool setIsOriginal(Scene& scene, unsigned int geomID, const Geometry* geometry, bool isOriginal);

  /* True if Embree's geometry with this ID is a substitute. instances: IDs of instances from `scene` to the scene with
   * this geometry, outermost first. An instance array counts as an instance of its first scene. */
  bool isSubstituted(RTCScene scene, const unsigned int* instances, unsigned int numInstances, unsigned int geomID);

private:
  void release(Geometry* geometry, Garbage& garbage);
  void release(Scene* scene, Garbage& garbage);

  std::mutex mutex;
  std::unordered_map<RTCScene, Scene*> scenes;
  std::unordered_map<RTCGeometry, Geometry*> geometries;
};

} // namespace interposer
