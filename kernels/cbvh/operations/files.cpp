// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "files.h"
#include "../files/file_statistics.h"
#include "../files/loaded_geometry.h"
#include "../files/loaded_surface.h"
#include "../files/saved_surface.h"
#include "../blocks/required_blocks.h"

namespace embree::core {
namespace {
/*! Rethrows errors of the codec as Embree's. */
template<typename Function>
auto withEmbreeErrors(const Function& function) -> decltype(function()) {
  try {
    return function();
  } catch (const cvert::Error& error) {
    throw_RTCError(error.code == cvert::ErrorCode::INVALID_OPERATION ? RTC_ERROR_INVALID_OPERATION
                                                                     : RTC_ERROR_INVALID_ARGUMENT,
                   error.what());
  }
}

/*! A geometry that can be saved: references its blocks, but not the geometry. */
struct SavableGeometry {
  const CompressibleGeometry* geometry;
  std::shared_ptr<const SurfaceBlocks> blocks;

  /*! Throws RTC_ERROR_INVALID_OPERATION if the geometry has no blocks, requests no compression, or changed since
   *  its last commit. */
  explicit SavableGeometry(Geometry* saved) : geometry(asCompressible(saved)) {
    if (geometry) blocks = cbvh::blocksOf(geometry);
    // scenes with compressed surfaces also build blocks for surfaces that request none
    const auto requestsCompression = [&] {
      return geometry->compression.resolve(geometry->device->compression).compression != RTC_COMPRESSION_NONE;
    };
    if (!blocks || !requestsCompression()) throwNotCompressed(geometry);
    if (saved->state != unsigned(Geometry::State::COMMITTED) || geometry->surface.isChanged())
      throw_RTCError(RTC_ERROR_INVALID_OPERATION, "the geometry cannot be saved: it changed since its last commit");
  }

  void addTo(cvert::FileWriter& writer) const {
    writer.requireOpen();
    cvert::FileSurface surface = cbvh::toFileSurface(geometry, *blocks);
    writer.add(surface);
  }
};

RTCGeometryType typeOf(const cvert::FileGeometry& record) {
  switch (record.source) {
  case cvert::FILE_GRIDS: return RTC_GEOMETRY_TYPE_GRID;
  case cvert::FILE_QUADS: return RTC_GEOMETRY_TYPE_QUAD;
  case cvert::FILE_TRIANGLES: return RTC_GEOMETRY_TYPE_TRIANGLE;
  default: return RTC_GEOMETRY_TYPE_SUBDIVISION;
  }
}

const cvert::FileGeometry& recordOf(const cvert::File& file, size_t index) {
  if (index >= file.size())
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, "invalid index " + std::to_string(index) + ": the file has " +
                                                   std::to_string(file.size()) + " geometries");
  return file.geometry(index);
}
} // namespace

void saveGeometry(Geometry* geometry, const char* path) {
  const SavableGeometry saved(geometry); // throws before a file is created
  withEmbreeErrors([&] {
    cvert::FileWriter writer(path);
    saved.addTo(writer);
    writer.commit();
  });
}

CompressedFileWriter::CompressedFileWriter(Device* device, const char* path)
  : device(device),
    writer(withEmbreeErrors([&] { return new cvert::FileWriter(path); })) {
  device->refInc();
}
CompressedFileWriter::CompressedFileWriter(Device* device, const char* path, uint64_t key)
  : device(device),
    writer(withEmbreeErrors([&] { return new cvert::FileWriter(path, key); })) {
  device->refInc();
}
CompressedFileWriter::~CompressedFileWriter() { device->refDec(); }

size_t CompressedFileWriter::size() const { return writer->size(); }
void CompressedFileWriter::append(Geometry* geometry) {
  withEmbreeErrors([&] { SavableGeometry(geometry).addTo(*writer); });
}
void CompressedFileWriter::commit() {
  withEmbreeErrors([&] { writer->commit(); });
}

CompressedFile::CompressedFile(Device* device, const char* path)
  : device(device),
    file(withEmbreeErrors([&] { return std::make_shared<const cvert::File>(path); })) {
  device->refInc();
}
CompressedFile::~CompressedFile() { device->refDec(); }

size_t CompressedFile::size() const { return file->size(); }

CompressedFileGeometryInfo CompressedFile::geometryInfo(size_t index) const {
  const cvert::FileGeometry& record = recordOf(*file, index);
  CompressedFileGeometryInfo info;
  info.type = typeOf(record);
  info.compression = RTCCompression(record.compression);
  info.numPrimitives = record.numPrimitives;
  info.numTimeSteps = record.numTimeSteps;
  info.begin = record.begin;
  info.end = record.end;
  for (int k = 0; k < 3; k++) {
    info.lower[k] = record.lower[k];
    info.upper[k] = record.upper[k];
  }
  info.bytes = size_t(record.treeBytes + record.blockBytes);
  return info;
}

cbvh::CompressionStatistics CompressedFile::statistics(size_t index) const {
  return cbvh::statisticsOf(recordOf(*file, index)).sums;
}

Geometry* CompressedFile::load(size_t index) const {
  const cvert::FileGeometry& record = recordOf(*file, index);
  Ref<Geometry> geometry =
      new LoadedGeometry(device, record, withEmbreeErrors([&] { return cbvh::loadSurface(file, device, index); }));
  geometry->refInc(); // the caller's reference
  return geometry.ptr;
}

void CompressedFile::verifyAll() const {
  withEmbreeErrors([&] { cbvh::verifyFile(*file); });
}
} // namespace embree::core
