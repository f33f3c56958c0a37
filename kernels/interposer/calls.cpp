// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Overrides Embree's functions for devices, scenes, instances, and the lifetime of geometries. Each calls Embree (REAL)
 * and keeps Objects consistent. Compressed geometry is built when its scene is committed. */

#include "devices.h"
#include "guarded.h"
#include "immortal.h"
#include "objects.h"
#include "options.h"

#include <cctype>
#include <string>

using namespace interposer;

namespace {

/* Returns the last item "threads=N" of a device's settings, or "". Builds by libembree_cbvh use as many threads. */
std::string threadsSettingOf(const char* config) {
  const std::string text = config ? config : "";
  std::string setting;
  for (size_t at = text.find("threads"); at != std::string::npos; at = text.find("threads", at + 1)) {
    if (at > 0 && (text[at - 1] == '_' || std::isalpha((unsigned char)text[at - 1]))) continue; // part of another key
    size_t digits = text.find_first_not_of(" \t\r\n=", at + 7), end = digits;
    while (end < text.size() && std::isdigit((unsigned char)text[end])) end++;
    if (digits != std::string::npos && end > digits) setting = "threads=" + text.substr(digits, end - digits);
  }
  return setting;
}

Devices& devices() { return immortal<Devices>(); }

bool isInstance(RTCGeometryType type) {
  return type == RTC_GEOMETRY_TYPE_INSTANCE || type == RTC_GEOMETRY_TYPE_INSTANCE_ARRAY;
}

/* Returns the application's handle of a geometry that Embree returned. */
RTCGeometry originalOf(RTCGeometry geometry) {
  if (!geometry || !hasSubstitutes() || !isActive()) return geometry;
  const SubstituteData* const data = asSubstituteData(REAL(rtcGetGeometryUserData)(geometry));
  return data ? data->original : geometry;
}

/* Returns the geometry that Embree must attach. isOriginal: receives true if it is the application's, false for the
 * substitute. */
RTCGeometry geometryToAttach(RTCGeometry geometry, bool& isOriginal) {
  Substituted* const substituted = isActive() ? Objects::get().findSubstituted(geometry) : nullptr;
  isOriginal = !substituted || substituted->isLeftToEmbree();
  return isOriginal ? geometry : substituted->substitute;
}

/* Detaches the geometry again, and returns false, if memory runs out. */
bool recordAttachment(RTCScene scene, unsigned int geomID, RTCGeometry geometry, bool isOriginal) {
  if (guarded("rtcAttachGeometry", [&] { Objects::get().attach(scene, geomID, geometry, isOriginal); })) return true;
  REAL(rtcDetachGeometry)(scene, geomID);
  return false;
}

/* Share of a scene's progress for builds by libembree_cbvh; the rest is for Embree's commit. */
constexpr double buildFraction = 0.9;

/* Progress function that Embree calls. Returns false to cancel the commit. */
bool reportProgress(void* ptr, double done) {
  const Scene& scene = *(const Scene*)ptr;
  const double begin = scene.hasBuilt ? buildFraction : 0;
  return !scene.isCanceled && (!scene.progress || scene.progress(scene.progressPtr, begin + (1 - begin) * done));
}

/* Builds the scene's enabled compressed geometries that were committed since their last build. In Embree's scene,
 * replaces originals by substitutes, or the reverse if a geometry cannot be compressed. Sets isCanceled if the
 * application cancels. */
void prepare(Scene& scene) {
  Objects& objects = Objects::get();
  const struct Retained {
    const std::vector<std::pair<unsigned int, Geometry*>> all;
    ~Retained() { Objects::get().releaseAll(all); }
  } retained = {objects.retainSubstituted(scene)};
  const auto& all = retained.all;
  size_t count = 0, done = 0;
  for (const auto& entry : all) count += entry.second->substituted->needsBuild();
  if (count > 0) scene.hasBuilt = true;
  for (const auto& entry : all) {
    Substituted& geometry = *entry.second->substituted;
    const bool needsBuild = geometry.needsBuild();
    if (needsBuild && !scene.isCanceled)
      scene.isCanceled = !geometry.build([&](double fraction) {
        return !scene.progress ||
               scene.progress(scene.progressPtr, buildFraction * (double(done) + fraction) / double(count));
      });
    done += needsBuild;
    const bool isOriginal = geometry.isLeftToEmbree();
    if (!objects.setIsOriginal(scene, entry.first, entry.second, isOriginal)) continue;
    REAL(rtcDetachGeometry)(scene.handle, entry.first);
    REAL(rtcAttachGeometryByID)(scene.handle, isOriginal ? entry.second->handle : geometry.substitute, entry.first);
  }
}

/* Exists while a thread commits a scene. A thread joins the commit of the threads before it, and shares their
 * cancellation, unless one of them has already finished. It then starts a new commit. */
class Commit {
public:
  explicit Commit(RTCScene handle) : scene(isActive() && handle ? Objects::get().find(handle) : nullptr) {
    if (!scene) return;
    const std::lock_guard<std::mutex> lock(scene->commitMutex);
    if (scene->startsNewCommit) scene->isCanceled = scene->hasBuilt = false;
    scene->startsNewCommit = false;
  }
  ~Commit() {
    if (!scene) return;
    const std::lock_guard<std::mutex> lock(scene->commitMutex);
    scene->startsNewCommit = true;
  }
  Commit(const Commit&) = delete;
  Commit& operator=(const Commit&) = delete;

  void prepare() {
    if (!scene) return;
    const std::lock_guard<std::mutex> lock(scene->prepareMutex);
    guarded("rtcCommitScene", [&] { ::prepare(*scene); });
  }

private:
  Scene* const scene;
};

} // namespace

/* --- devices ------------------------------------------------------------------------------- */

RTC_API RTCDevice rtcNewDevice(const char* config) {
  const RTCDevice device = REAL(rtcNewDevice)(config);
  if (device && isActive()) guarded("rtcNewDevice", [&] { devices().add(device, threadsSettingOf(config)); });
  return device;
}

RTC_API void rtcRetainDevice(RTCDevice device) {
  REAL(rtcRetainDevice)(device);
  if (isActive()) devices().retain(device);
}

RTC_API void rtcReleaseDevice(RTCDevice device) {
  if (isActive()) devices().release(device);
  REAL(rtcReleaseDevice)(device);
}

/* The caller must release the result. A scene can hold the last reference to its device, which is then unknown. */
RTC_API RTCDevice rtcGetSceneDevice(RTCScene scene) {
  const RTCDevice device = REAL(rtcGetSceneDevice)(scene);
  if (isActive() && !devices().retain(device) && Objects::get().find(scene))
    guarded("rtcGetSceneDevice", [&] { devices().add(device, ""); });
  return device;
}

/* --- scenes -------------------------------------------------------------------------------- */

RTC_API RTCScene rtcNewScene(RTCDevice device) {
  const RTCScene scene = REAL(rtcNewScene)(device);
  if (!scene || !isActive() || !devices().contains(device)) return scene;
  if (guarded("rtcNewScene", [&] { Objects::get().addScene(scene); })) return scene;
  REAL(rtcReleaseScene)(scene);
  return nullptr;
}

RTC_API void rtcRetainScene(RTCScene scene) {
  REAL(rtcRetainScene)(scene);
  if (isActive()) Objects::get().retain(scene);
}

RTC_API void rtcReleaseScene(RTCScene scene) {
  /* Objects must forget the scene before Embree frees it and reuses its address. Garbage is destroyed last. */
  const Objects::Garbage garbage = isActive() ? Objects::get().release(scene) : Objects::Garbage();
  REAL(rtcReleaseScene)(scene);
}

RTC_API unsigned int rtcAttachGeometry(RTCScene scene, RTCGeometry geometry) {
  bool isOriginal;
  const unsigned int geomID = REAL(rtcAttachGeometry)(scene, geometryToAttach(geometry, isOriginal));
  if (geomID == RTC_INVALID_GEOMETRY_ID || !isActive() || recordAttachment(scene, geomID, geometry, isOriginal))
    return geomID;
  return RTC_INVALID_GEOMETRY_ID;
}

RTC_API void rtcAttachGeometryByID(RTCScene scene, RTCGeometry geometry, unsigned int geomID) {
  bool isOriginal;
  const RTCGeometry attached = geometryToAttach(geometry, isOriginal);
  REAL(rtcAttachGeometryByID)(scene, attached, geomID);
  if (!isActive() || !scene || !geometry || geomID == RTC_INVALID_GEOMETRY_ID || !Objects::get().find(geometry)) return;
  /* Embree reports an error if another geometry already has the ID */
  if (REAL(rtcGetGeometryThreadSafe)(scene, geomID) == attached) recordAttachment(scene, geomID, geometry, isOriginal);
}

RTC_API void rtcDetachGeometry(RTCScene scene, unsigned int geomID) {
  const Objects::Garbage garbage = isActive() ? Objects::get().detach(scene, geomID) : Objects::Garbage();
  REAL(rtcDetachGeometry)(scene, geomID);
}

RTC_API RTCGeometry rtcGetGeometry(RTCScene scene, unsigned int geomID) {
  return originalOf(REAL(rtcGetGeometry)(scene, geomID));
}
RTC_API RTCGeometry rtcGetGeometryThreadSafe(RTCScene scene, unsigned int geomID) {
  return originalOf(REAL(rtcGetGeometryThreadSafe)(scene, geomID));
}

RTC_API void* rtcGetGeometryUserDataFromScene(RTCScene scene, unsigned int geomID) {
  void* const userData = REAL(rtcGetGeometryUserDataFromScene)(scene, geomID);
  const SubstituteData* const data = asSubstituteData(userData);
  return data ? data->userData : userData;
}

RTC_API void rtcCommitScene(RTCScene scene) {
  Commit commit(scene);
  commit.prepare();
  REAL(rtcCommitScene)(scene);
}

RTC_API void rtcJoinCommitScene(RTCScene scene) {
  Commit commit(scene);
  commit.prepare();
  REAL(rtcJoinCommitScene)(scene);
}

RTC_API void rtcSetSceneProgressMonitorFunction(RTCScene scene, RTCProgressMonitorFunction progress, void* ptr) {
  Scene* const found = isActive() && scene ? Objects::get().find(scene) : nullptr;
  if (!found) {
    REAL(rtcSetSceneProgressMonitorFunction)(scene, progress, ptr);
    return;
  }
  found->progress = progress;
  found->progressPtr = ptr;
  REAL(rtcSetSceneProgressMonitorFunction)(scene, progress ? reportProgress : nullptr, found);
}

/* --- geometries ----------------------------------------------------------------------------- */

RTC_API RTCGeometry rtcNewGeometry(RTCDevice device, RTCGeometryType type) {
  const RTCGeometry geometry = REAL(rtcNewGeometry)(device, type);
  if (!geometry || !isActive() || !devices().contains(device)) return geometry;
  const bool isRecorded = guarded("rtcNewGeometry", [&] {
    if (isInstance(type)) Objects::get().addGeometry(geometry, type, nullptr);
    if (!options().compresses(type)) return;
    if (auto substituted = Substituted::make(device, devices().settingsOf(device), geometry, type))
      Objects::get().addGeometry(geometry, type, std::move(substituted));
  });
  if (isRecorded) return geometry;
  REAL(rtcReleaseGeometry)(geometry);
  return nullptr;
}

RTC_API void rtcRetainGeometry(RTCGeometry geometry) {
  REAL(rtcRetainGeometry)(geometry);
  if (isActive()) Objects::get().retain(geometry);
}

RTC_API void rtcReleaseGeometry(RTCGeometry geometry) {
  const Objects::Garbage garbage = isActive() ? Objects::get().release(geometry) : Objects::Garbage();
  REAL(rtcReleaseGeometry)(geometry);
}

RTC_API void rtcSetGeometryInstancedScene(RTCGeometry geometry, RTCScene scene) {
  REAL(rtcSetGeometryInstancedScene)(geometry, scene);
  if (isActive()) Objects::get().setInstancedScene(geometry, scene);
}

RTC_API void rtcSetGeometryInstancedScenes(RTCGeometry geometry, RTCScene* scenes, size_t numScenes) {
  if (!isActive() || !scenes || !Objects::get().find(geometry)) {
    REAL(rtcSetGeometryInstancedScenes)(geometry, scenes, numScenes);
    return;
  }
  std::vector<Scene*> storage;
  if (!guarded("rtcSetGeometryInstancedScenes", [&] { storage.resize(numScenes); })) return;
  REAL(rtcSetGeometryInstancedScenes)(geometry, scenes, numScenes);
  Objects::get().setInstancedScenes(geometry, scenes, numScenes, storage);
}
