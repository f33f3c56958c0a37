// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Functions of cbvh.h on Embree's geometries, through embree3/rtcore_surface.h. Errors are those of the device.
 *
 * Functions are looked up in libembree3, because some tests also link libembree_cbvh, which has functions with the same
 * names. */

#include <embree3/rtcore_surface.h>

#include <dlfcn.h>
#include <stdexcept>
#include <string>

namespace programs::test {

inline void* functionOfLibembree3(const char* name) {
  static void* const library = dlopen("libembree3.so.3", RTLD_LAZY | RTLD_NOLOAD);
  void* const function = library ? dlsym(library, name) : nullptr;
  if (!function) throw std::runtime_error(std::string("libembree3 has no ") + name);
  return function;
}

#define OF_LIBEMBREE3(name) \
  ([] { \
    static const auto function = reinterpret_cast<decltype(&name)>(functionOfLibembree3(#name)); \
    return function; \
  }())

class SurfaceOfGeometry {
public:
  explicit SurfaceOfGeometry(RTCGeometry geometry) : surface(rtcNewSurfaceFromGeometry(geometry)) {}
  ~SurfaceOfGeometry() { OF_LIBEMBREE3(cbvhReleaseSurface)(surface); }
  SurfaceOfGeometry(const SurfaceOfGeometry&) = delete;
  SurfaceOfGeometry& operator=(const SurfaceOfGeometry&) = delete;
  operator CbvhSurface() const { return surface; }

private:
  const CbvhSurface surface;
};

class ContextOfDevice {
public:
  explicit ContextOfDevice(RTCDevice device) : context(rtcNewContextFromDevice(device)) {}
  ~ContextOfDevice() { OF_LIBEMBREE3(cbvhReleaseContext)(context); }
  ContextOfDevice(const ContextOfDevice&) = delete;
  ContextOfDevice& operator=(const ContextOfDevice&) = delete;
  operator CbvhContext() const { return context; }

private:
  const CbvhContext context;
};

// --- triangles, parts and clusters. Functions that return false end the enumeration. -----------

inline bool findStoredTriangle(RTCGeometry geometry, float time, unsigned primID, float u, float v, const float* Ng,
                               CbvhTriangle* triangle) {
  return OF_LIBEMBREE3(cbvhFindTriangle)(SurfaceOfGeometry(geometry), time, primID, u, v, Ng, triangle) != 0;
}

using StoredPartFunction = bool (*)(void* userPtr, const CbvhPart* part);

inline CbvhError forEachStoredPart(RTCGeometry geometry, float time, StoredPartFunction function, void* userPtr) {
  struct Call {
    StoredPartFunction function;
    void* userPtr;
  } call = {function, userPtr};
  const CbvhPartFunction forward = [](void* self, const CbvhPart* part) {
    return int(((Call*)self)->function(((Call*)self)->userPtr, part));
  };
  return OF_LIBEMBREE3(cbvhForEachPart)(SurfaceOfGeometry(geometry), time, function ? forward : nullptr, &call);
}

using StoredClusterFunction = bool (*)(void* userPtr, const CbvhCluster* cluster);

inline CbvhError forEachStoredCluster(RTCGeometry geometry, float time, CbvhClusterFormat format,
                                      StoredClusterFunction function, void* userPtr,
                                      CbvhClusterStatistics* statistics) {
  struct Call {
    StoredClusterFunction function;
    void* userPtr;
  } call = {function, userPtr};
  const CbvhClusterFunction forward = [](void* self, const CbvhCluster* cluster) {
    return int(((Call*)self)->function(((Call*)self)->userPtr, cluster));
  };
  return OF_LIBEMBREE3(cbvhForEachCluster)(SurfaceOfGeometry(geometry), time, format, function ? forward : nullptr,
                                           &call, statistics);
}

// --- dicing --------------------------------------------------------------------------------------

inline CbvhError diceGeometry(RTCGeometry geometry, const CbvhDicingArguments* args, float* rates = nullptr) {
  return OF_LIBEMBREE3(cbvhDiceSurface)(SurfaceOfGeometry(geometry), args, rates);
}

// --- files ---------------------------------------------------------------------------------------

inline bool saveGeometryFile(RTCGeometry geometry, const char* path) {
  return OF_LIBEMBREE3(cbvhSaveSurface)(SurfaceOfGeometry(geometry), path) == CBVH_OK;
}

// Releases the surface.
inline RTCGeometry geometryOf(RTCDevice device, CbvhSurface surface) {
  if (!surface) return nullptr;
  RTCGeometry geometry = rtcNewGeometryFromSurface(device, surface);
  OF_LIBEMBREE3(cbvhReleaseSurface)(surface);
  return geometry;
}

inline RTCGeometry loadGeometryFile(RTCDevice device, const char* path) {
  CbvhSurface surface = nullptr;
  OF_LIBEMBREE3(cbvhLoadSurface)(ContextOfDevice(device), path, &surface);
  return geometryOf(device, surface);
}

inline CbvhFileWriter newFileWriter(RTCDevice device, const char* path) {
  CbvhFileWriter writer = nullptr;
  OF_LIBEMBREE3(cbvhNewFileWriter)(ContextOfDevice(device), path, &writer);
  return writer;
}

inline CbvhFileWriter resumeFileWriter(RTCDevice device, const char* path, unsigned long long key) {
  CbvhFileWriter writer = nullptr;
  OF_LIBEMBREE3(cbvhResumeFileWriter)(ContextOfDevice(device), path, key, &writer);
  return writer;
}

inline size_t countOf(CbvhFileWriter writer) { return OF_LIBEMBREE3(cbvhGetFileWriterSurfaceCount)(writer); }

inline bool appendGeometry(CbvhFileWriter writer, RTCGeometry geometry) {
  return OF_LIBEMBREE3(cbvhAppendSurface)(writer, SurfaceOfGeometry(geometry)) == CBVH_OK;
}

inline bool commitWriter(CbvhFileWriter writer) { return OF_LIBEMBREE3(cbvhCommitFileWriter)(writer) == CBVH_OK; }

inline void releaseWriter(CbvhFileWriter writer) { OF_LIBEMBREE3(cbvhReleaseFileWriter)(writer); }

inline CbvhFile openFile(RTCDevice device, const char* path) {
  CbvhFile file = nullptr;
  OF_LIBEMBREE3(cbvhOpenFile)(ContextOfDevice(device), path, &file);
  return file;
}

inline size_t countOf(CbvhFile file) { return OF_LIBEMBREE3(cbvhGetFileSurfaceCount)(file); }

inline bool infoOf(CbvhFile file, size_t index, CbvhFileSurfaceInfo* info) {
  return OF_LIBEMBREE3(cbvhGetFileSurfaceInfo)(file, index, info) == CBVH_OK;
}

inline bool statisticsOf(CbvhFile file, size_t index, CbvhSurfaceStatistics* statistics) {
  return OF_LIBEMBREE3(cbvhGetFileSurfaceStatistics)(file, index, statistics) == CBVH_OK;
}

inline RTCGeometry loadFromFile(RTCDevice device, CbvhFile file, size_t index) {
  CbvhSurface surface = nullptr;
  OF_LIBEMBREE3(cbvhLoadFileSurface)(file, index, &surface);
  return geometryOf(device, surface);
}

inline bool verifyFile(CbvhFile file) { return OF_LIBEMBREE3(cbvhVerifyFile)(file) == CBVH_OK; }

inline void releaseFile(CbvhFile file) { OF_LIBEMBREE3(cbvhReleaseFile)(file); }

} // namespace programs::test
