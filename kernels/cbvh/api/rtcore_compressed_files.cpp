// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#define RTC_EXPORT_API

#include "../../../include/embree3/rtcore_compressed_files.h"
#include "../embree/scene.h"
#include "../files/codec_errors.h"
#include "../files/file_statistics.h"
#include "../files/loaded_surface.h"
#include "../files/saved_surface.h"
#include "../stored/surface_blocks.h"
#include "loaded_geometry.h"

using namespace embree;

namespace
{
  /*! what a handle stands for, with the device that has its errors */
  template<typename T>
  struct Held : public RefCount
  {
    Held (Device* device, T&& thing) : device(device), thing(std::move(thing)) { device->refInc(); }
    ~Held () { device->refDec(); }

    Device* device;
    T thing;
  };
  typedef Held<std::shared_ptr<const cvert::File>> OpenFile;
  typedef Held<std::unique_ptr<cvert::FileWriter>> Writer;

  void require (const void* argument, const char* name) {
    if (!argument) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,std::string(name) + " is NULL");
  }

  void requireGeometry (const cvert::File& file, size_t index)
  {
    if (index >= file.size())
      throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"index " + std::to_string(index) + ": the file has " + std::to_string(file.size()) + " geometries");
  }

  /*! with its blocks */
  const CompressibleGeometry* compressedOf (Geometry* geometry, std::shared_ptr<const SurfaceBlocks>& blocks)
  {
    const CompressibleGeometry* const compressible = embree::compressible(geometry);
    if (compressible) blocks = cbvh::blocksOf(compressible);
    /* a scene that compresses others has trees of surfaces that do not ask for it, too */
    const auto asks = [&] {
      const CompressionSettings settings = compressible->compression.resolve(compressible->device->compression);
      return settings.compression != RTC_COMPRESSION_NONE;
    };
    if (!blocks || !asks())
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,"the geometry has not been compressed: it asks for no compression, or neither it nor its scene was committed");
    if (geometry->state != unsigned(Geometry::State::COMMITTED))
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,"the geometry was changed since it was committed");
    return compressible;
  }

  void add (cvert::FileWriter& writer, const CompressibleGeometry* geometry, const SurfaceBlocks& blocks)
  {
    writer.requireOpen();
    cvert::FileSurface surface = cbvh::savedSurface(geometry,blocks);
    writer.add(surface);
  }

  void append (cvert::FileWriter& writer, Geometry* geometry)
  {
    std::shared_ptr<const SurfaceBlocks> blocks;
    const CompressibleGeometry* const compressed = compressedOf(geometry,blocks);
    add(writer,compressed,*blocks);
  }

  std::shared_ptr<const cvert::File> open (const char* path) { return cbvh::withEmbreeErrors([&] { return std::make_shared<const cvert::File>(path); }); }

  template<typename New>
  RTCCompressedFileWriter newWriter (Device* device, const New& make) {
    return (RTCCompressedFileWriter)(new Writer(device,std::unique_ptr<cvert::FileWriter>(cbvh::withEmbreeErrors(make))))->refInc();
  }

  RTCGeometry load (const std::shared_ptr<const cvert::File>& file, Device* device, size_t i) {
    const std::shared_ptr<const SurfaceBlocks> blocks = cbvh::withEmbreeErrors([&] { return cbvh::loadSurface(file,device,i); });
    return (RTCGeometry)(new LoadedGeometry(device,file->geometry(i),blocks))->refInc();
  }

  enum RTCGeometryType typeOf (const cvert::FileGeometry& record)
  {
    switch (record.source) {
    case cvert::FILE_GRIDS: return RTC_GEOMETRY_TYPE_GRID;
    case cvert::FILE_QUADS: return RTC_GEOMETRY_TYPE_QUAD;
    case cvert::FILE_TRIANGLES: return RTC_GEOMETRY_TYPE_TRIANGLE;
    default: return RTC_GEOMETRY_TYPE_SUBDIVISION;
    }
  }
}

RTC_NAMESPACE_BEGIN;

RTC_API bool rtcSaveCompressedGeometry (RTCGeometry hgeometry, const char* path)
{
  Geometry* geometry = (Geometry*) hgeometry;
  RTC_CATCH_BEGIN;
  require(geometry,"geometry");
  require(path,"path");
  std::shared_ptr<const SurfaceBlocks> blocks;
  const CompressibleGeometry* const compressed = compressedOf(geometry,blocks); // before a file is begun
  cbvh::withEmbreeErrors([&] {
    cvert::FileWriter writer(path);
    add(writer,compressed,*blocks);
    writer.commit();
  });
  return true;
  RTC_CATCH_END2(geometry);
  return false;
}

RTC_API RTCGeometry rtcLoadCompressedGeometry (RTCDevice hdevice, const char* path)
{
  Device* device = (Device*) hdevice;
  RTC_CATCH_BEGIN;
  require(device,"device");
  require(path,"path");
  const std::shared_ptr<const cvert::File> file = open(path);
  if (file->size() != 1)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,std::string(path) + ": has " + std::to_string(file->size()) + " geometries, which rtcOpenCompressedFile opens");
  return load(file,device,0);
  RTC_CATCH_END(device);
  return nullptr;
}

RTC_API RTCCompressedFileWriter rtcNewCompressedFileWriter (RTCDevice hdevice, const char* path)
{
  Device* device = (Device*) hdevice;
  RTC_CATCH_BEGIN;
  require(device,"device");
  require(path,"path");
  return newWriter(device,[&] { return new cvert::FileWriter(path); });
  RTC_CATCH_END(device);
  return nullptr;
}

RTC_API RTCCompressedFileWriter rtcResumeCompressedFileWriter (RTCDevice hdevice, const char* path, unsigned long long key)
{
  Device* device = (Device*) hdevice;
  RTC_CATCH_BEGIN;
  require(device,"device");
  require(path,"path");
  return newWriter(device,[&] { return new cvert::FileWriter(path,key); });
  RTC_CATCH_END(device);
  return nullptr;
}

RTC_API unsigned int rtcGetCompressedFileWriterCount (RTCCompressedFileWriter hwriter)
{
  Writer* writer = (Writer*) hwriter;
  RTC_CATCH_BEGIN;
  require(writer,"writer");
  return (unsigned int)writer->thing->size();
  RTC_CATCH_END(nullptr);
  return 0;
}

RTC_API bool rtcAppendCompressedGeometry (RTCCompressedFileWriter hwriter, RTCGeometry hgeometry)
{
  Writer* writer = (Writer*) hwriter;
  RTC_CATCH_BEGIN;
  require(writer,"writer");
  require(hgeometry,"geometry");
  cbvh::withEmbreeErrors([&] { append(*writer->thing,(Geometry*)hgeometry); });
  return true;
  RTC_CATCH_END2(writer);
  return false;
}

RTC_API bool rtcCommitCompressedFile (RTCCompressedFileWriter hwriter)
{
  Writer* writer = (Writer*) hwriter;
  RTC_CATCH_BEGIN;
  require(writer,"writer");
  cbvh::withEmbreeErrors([&] { writer->thing->commit(); });
  return true;
  RTC_CATCH_END2(writer);
  return false;
}

RTC_API void rtcReleaseCompressedFileWriter (RTCCompressedFileWriter hwriter)
{
  Writer* writer = (Writer*) hwriter;
  RTC_CATCH_BEGIN;
  require(writer,"writer");
  writer->refDec();
  RTC_CATCH_END(nullptr);
}

RTC_API RTCCompressedFile rtcOpenCompressedFile (RTCDevice hdevice, const char* path)
{
  Device* device = (Device*) hdevice;
  RTC_CATCH_BEGIN;
  require(device,"device");
  require(path,"path");
  return (RTCCompressedFile)(new OpenFile(device,open(path)))->refInc();
  RTC_CATCH_END(device);
  return nullptr;
}

RTC_API unsigned int rtcGetCompressedFileGeometryCount (RTCCompressedFile hfile)
{
  OpenFile* file = (OpenFile*) hfile;
  RTC_CATCH_BEGIN;
  require(file,"file");
  return unsigned(file->thing->size());
  RTC_CATCH_END2(file);
  return 0;
}

RTC_API bool rtcGetCompressedFileGeometry (RTCCompressedFile hfile, unsigned int index, struct RTCCompressedFileGeometry* description)
{
  OpenFile* file = (OpenFile*) hfile;
  RTC_CATCH_BEGIN;
  require(file,"file");
  require(description,"description");
  requireGeometry(*file->thing,index);
  const cvert::FileGeometry& record = file->thing->geometry(index);
  *description = RTCCompressedFileGeometry();
  description->type = typeOf(record);
  description->compression = RTCCompression(record.compression);
  description->primitiveCount = record.numPrimitives;
  description->timeStepCount = record.numTimeSteps;
  description->begin = record.begin;
  description->end = record.end;
  for (int k=0; k<3; k++) { description->lower[k] = record.lower[k]; description->upper[k] = record.upper[k]; }
  description->statistics = cbvh::statisticsOf(record).sums;
  description->bytes = size_t(record.treeBytes + record.blockBytes);
  return true;
  RTC_CATCH_END2(file);
  return false;
}

RTC_API RTCGeometry rtcNewGeometryFromCompressedFile (RTCCompressedFile hfile, unsigned int index)
{
  OpenFile* file = (OpenFile*) hfile;
  RTC_CATCH_BEGIN;
  require(file,"file");
  requireGeometry(*file->thing,index);
  return load(file->thing,file->device,index);
  RTC_CATCH_END2(file);
  return nullptr;
}

RTC_API bool rtcVerifyCompressedFile (RTCCompressedFile hfile)
{
  OpenFile* file = (OpenFile*) hfile;
  RTC_CATCH_BEGIN;
  require(file,"file");
  cbvh::withEmbreeErrors([&] { cbvh::verifyFile(*file->thing); });
  return true;
  RTC_CATCH_END2(file);
  return false;
}

RTC_API void rtcReleaseCompressedFile (RTCCompressedFile hfile)
{
  OpenFile* file = (OpenFile*) hfile;
  RTC_CATCH_BEGIN;
  require(file,"file");
  file->refDec();
  RTC_CATCH_END(nullptr);
}

RTC_NAMESPACE_END
