// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The application's scenes and geometries. A substitute must exist while a scene contains its geometry, but Embree does
 * not report when a scene releases the geometry. This file therefore counts references as Embree does: references of
 * the application, of scenes to geometries, and of instances to scenes. */

#include "geometry.h"
#include "immortal.h"

#include <map>
#include <memory>
#include <vector>

namespace interposer {

struct Scene;

/* The scenes of an instance or an instance array, and how Embree 4.3 and 4.4 choose one for each instance of an array.
 * Embree holds a reference to all of them. */
struct InstancedScenes {
  Scene* only = nullptr;     // if set: the scene of all instances, also after rtcSetGeometryInstancedScenes
  std::vector<Scene*> all;   // of rtcSetGeometryInstancedScenes; NULL where the application passed NULL
  Buffer indices = Buffer(); // for each instance of an array: an index into `all`
  size_t numTransforms = 0;  // of the first time step of an array: its number of instances

  /* Returns NULL if the instance has no scene. Reads the index buffer, whose owner is Embree or the application. */
  const Scene* find(unsigned int instPrimID) const;
};

/* A geometry with a substitute, an instance or an instance array. */
struct Geometry {
  RTCGeometry handle;
  RTCGeometryType type;
  size_t references = 1;
  std::unique_ptr<Substituted> substituted;
  InstancedScenes instanced; // empty for other geometries
};

struct Attachment {
  Geometry* geometry;
  bool isOriginal; // Embree's scene contains the original, not the substitute
};

struct Scene {
  RTCScene handle;
  size_t references = 1;
  std::map<unsigned int, Attachment> attachments; // by geomID; only geometries that Objects contains
  RTCProgressMonitorFunction progress = nullptr;  // the application's
  void* progressPtr = nullptr;
  std::mutex prepareMutex;             // held while a thread builds substitutes
  std::mutex commitMutex;              // protects startsNewCommit
  bool startsNewCommit = true;         // true if the next thread starts a new commit, see Commit in calls.cpp
  std::atomic<bool> isCanceled{false}; // for all threads that joined the current commit
  std::atomic<bool> hasBuilt{false};   // the current commit has built substitutes
};

/* Thread-safe. Handles that Objects does not contain are ignored. A function that throws std::bad_alloc, as stated,
 * changes nothing; other functions do not allocate. */
class Objects {
  typedef std::map<RTCScene, std::unique_ptr<Scene>> Scenes;
  typedef std::map<RTCGeometry, std::unique_ptr<Geometry>> Geometries;

public:
  /* Never destroyed, because programs release geometries in destructors of static objects. */
  static Objects& get() { return immortal<Objects>(); }

  /* Throw std::bad_alloc. */
  void addScene(RTCScene scene);
  /* substituted: NULL for instances and instance arrays. */
  void addGeometry(RTCGeometry geometry, RTCGeometryType type, std::unique_ptr<Substituted> substituted);

  /* Return NULL for unknown objects. The result is valid while the caller holds a reference to the handle. */
  Scene* find(RTCScene scene);
  Geometry* find(RTCGeometry geometry);
  Substituted* findSubstituted(RTCGeometry geometry);

  void retain(RTCScene scene);
  void retain(RTCGeometry geometry);

  /* Objects without references, including the released object itself. The caller must keep them until Embree has
   * released that object. Destroying them calls Embree, so Objects must not be locked then. Nodes of maps move here
   * without allocations. */
  struct Garbage {
    Geometries geometries;
    Scenes scenes;
  };
  Garbage release(RTCScene scene);
  Garbage release(RTCGeometry geometry);

  /* Throws std::bad_alloc. */
  void attach(RTCScene scene, unsigned int geomID, RTCGeometry geometry, bool isOriginal);
  Garbage detach(RTCScene scene, unsigned int geomID);

  /* Changes of instances and instance arrays, to call after Embree's function. Calls that Embree rejects, and calls for
   * other geometries, have no effect. */
  Garbage setInstancedScene(RTCGeometry geometry, RTCScene scene);
  /* storage: `count` elements, allocated before Embree's function is called. */
  Garbage setInstancedScenes(RTCGeometry geometry, const RTCScene* scenes, size_t count, std::vector<Scene*>& storage);
  void setArrayBuffer(RTCGeometry geometry, RTCBufferType type, unsigned int slot, const Buffer& buffer);
  void commitArray(RTCGeometry geometry);

  /* Retains and returns the attached geometries that have substitutes, with their geomIDs. The caller must pass the
   * result to releaseAll. Throws std::bad_alloc. */
  std::vector<std::pair<unsigned int, Geometry*>> retainSubstituted(Scene& scene);
  Garbage releaseAll(const std::vector<std::pair<unsigned int, Geometry*>>& all);
  /* Records whether Embree's scene must contain the original or the substitute. Returns true if the caller must replace
   * one by the other, and false if nothing changes, or if another thread has detached the geometry. */
  bool setIsOriginal(Scene& scene, unsigned int geomID, const Geometry* geometry, bool isOriginal);

  /* Returns the data of Embree's geometry with this ID, or NULL if it is no substitute. context: its instances from
   * firstLevel on lead from `scene` to the scene with this geometry, outermost first. The result is valid until the
   * scene is changed. */
  const SubstituteData* findSubstitute(RTCScene scene, const RTCPointQueryContext& context, unsigned int firstLevel,
                                       unsigned int geomID);

private:
  /* Callers hold the mutex. */
  void release(Geometry* geometry, Garbage& garbage);
  void release(Scene* scene, Garbage& garbage); // does nothing for NULL
  Scene* findAndRetain(RTCScene scene);         // returns NULL for unknown scenes
  Geometry* findArray(RTCGeometry geometry);    // returns NULL for other geometries

  std::mutex mutex;
  Scenes scenes;
  Geometries geometries;
};

} // namespace interposer
