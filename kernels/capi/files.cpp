// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Files of surfaces, and their writers: handles of kernels/cbvh/operations/files.h. */

#include "surface.h"
#include "structs.h"

#include <algorithm>
#include <string>

using namespace embree::capi;
namespace core = embree::core;

struct CbvhFileWriterTy {
  template<typename... Key>
  CbvhFileWriterTy(CbvhContext context, const char* path, Key... key)
    : context(context),
      writer(context->embreeDevice(), path, key...) {}

  const RefPtr<CbvhContextTy> context;
  core::CompressedFileWriter writer;
};

struct CbvhFileTy {
  CbvhFileTy(CbvhContext context, const char* path) : context(context), file(context->embreeDevice(), path) {}

  const RefPtr<CbvhContextTy> context;
  const core::CompressedFile file;
};

namespace {

CbvhSurface loadSurface(const CbvhFileTy& file, size_t index) {
  NewPtr<CbvhSurfaceTy> surface(new CbvhSurfaceTy(file.context.get()));
  surface->load(file.file, index);
  return surface.release();
}

CbvhSurfaceType typeOf(RTCGeometryType type) {
  switch (type) {
  case RTC_GEOMETRY_TYPE_GRID: return CBVH_SURFACE_TYPE_GRIDS;
  case RTC_GEOMETRY_TYPE_QUAD: return CBVH_SURFACE_TYPE_QUADS;
  case RTC_GEOMETRY_TYPE_TRIANGLE: return CBVH_SURFACE_TYPE_TRIANGLES;
  default: return CBVH_SURFACE_TYPE_CAGE;
  }
}

static_assert(CBVH_REPRESENTATION_CGRID == int(RTC_COMPRESSION_CGRID) &&
                  CBVH_REPRESENTATION_CVOXEL == int(RTC_COMPRESSION_CVOXEL) &&
                  CBVH_REPRESENTATION_CLEAF == int(RTC_COMPRESSION_CLEAF) &&
                  CBVH_REPRESENTATION_CVERT == int(RTC_COMPRESSION_CVERT),
              "values of CbvhRepresentation");

/* Calls closure(file) and reports its exceptions to the context of the file. */
template<typename File, typename Closure>
CbvhError onFile(File* file, const char* name, const Closure& closure) {
  if (!file) return rejectArgument((std::string(name) + " is NULL").c_str());
  return guarded(file->context.get(), [&] { closure(*file); });
}

} // namespace

CbvhError cbvhSaveSurface(CbvhSurface surface, const char* path) {
  if (!surface) return rejectArgument("surface is NULL");
  return guarded(surface->context.get(), [&] {
    require(path, "path is NULL");
    core::saveGeometry(surface->committedInput()->embreeGeometry(), path);
  });
}

CbvhError cbvhLoadSurface(CbvhContext context, const char* path, CbvhSurface* surface) {
  if (!context) return rejectArgument("context is NULL");
  return guarded(context, [&] {
    require(path && surface, "path or surface is NULL");
    const CbvhFileTy file(context, path);
    if (file.file.size() != 1)
      throwInvalidArgument(std::string(path) + ": has " + std::to_string(file.file.size()) +
                           " geometries: expected 1; use cbvhOpenFile");
    *surface = loadSurface(file, 0);
  });
}

CbvhError cbvhNewFileWriter(CbvhContext context, const char* path, CbvhFileWriter* writer) {
  if (!context) return rejectArgument("context is NULL");
  return guarded(context, [&] {
    require(path && writer, "path or writer is NULL");
    *writer = new CbvhFileWriterTy(context, path);
  });
}

CbvhError cbvhResumeFileWriter(CbvhContext context, const char* path, unsigned long long key, CbvhFileWriter* writer) {
  if (!context) return rejectArgument("context is NULL");
  return guarded(context, [&] {
    require(path && writer, "path or writer is NULL");
    *writer = new CbvhFileWriterTy(context, path, uint64_t(key));
  });
}

void cbvhReleaseFileWriter(CbvhFileWriter writer) { delete writer; }

size_t cbvhGetFileWriterSurfaceCount(CbvhFileWriter writer) { return writer ? writer->writer.size() : 0; }

CbvhError cbvhAppendSurface(CbvhFileWriter writer, CbvhSurface surface) {
  return onFile(writer, "writer", [&](CbvhFileWriterTy& to) {
    require(surface, "surface is NULL");
    to.writer.append(surface->committedInput()->embreeGeometry());
  });
}

CbvhError cbvhCommitFileWriter(CbvhFileWriter writer) {
  return onFile(writer, "writer", [](CbvhFileWriterTy& to) { to.writer.commit(); });
}

CbvhError cbvhOpenFile(CbvhContext context, const char* path, CbvhFile* file) {
  if (!context) return rejectArgument("context is NULL");
  return guarded(context, [&] {
    require(path && file, "path or file is NULL");
    *file = new CbvhFileTy(context, path);
  });
}

void cbvhReleaseFile(CbvhFile file) { delete file; }

size_t cbvhGetFileSurfaceCount(CbvhFile file) { return file ? file->file.size() : 0; }

CbvhError cbvhGetFileSurfaceInfo(CbvhFile file, size_t index, CbvhFileSurfaceInfo* info) {
  return onFile(file, "file", [&](const CbvhFileTy& opened) {
    require(info, "info is NULL");
    const core::CompressedFileGeometryInfo from = opened.file.geometryInfo(index);
    CbvhFileSurfaceInfo to;
    to.type = typeOf(from.type);
    to.representation = CbvhRepresentation(from.compression);
    to.numPrimitives = from.numPrimitives;
    to.numTimeSteps = from.numTimeSteps;
    to.startTime = from.begin;
    to.endTime = from.end;
    std::copy_n(from.lower, 3, to.lower);
    std::copy_n(from.upper, 3, to.upper);
    to.bytes = from.bytes;
    core::writeStruct(info, to);
  });
}

CbvhError cbvhGetFileSurfaceStatistics(CbvhFile file, size_t index, CbvhSurfaceStatistics* statistics) {
  return onFile(file, "file", [&](const CbvhFileTy& opened) {
    require(statistics, "statistics is NULL");
    core::writeStruct(statistics, toPublic(opened.file.statistics(index)));
  });
}

CbvhError cbvhLoadFileSurface(CbvhFile file, size_t index, CbvhSurface* surface) {
  return onFile(file, "file", [&](const CbvhFileTy& opened) {
    require(surface, "surface is NULL");
    *surface = loadSurface(opened, index);
  });
}

CbvhError cbvhVerifyFile(CbvhFile file) {
  return onFile(file, "file", [](const CbvhFileTy& opened) { opened.file.verifyAll(); });
}
