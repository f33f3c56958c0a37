// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed geometries in files (docs/formats/file.md), with the contracts of include/cbvh/cbvh.h. Errors are thrown.
 * A file is mapped: rays can be traced immediately, blocks that no ray reaches stay on disk, and processes share the
 * memory. A mapped file may be replaced or removed, but must not be written or truncated. */

#include "../base/surface_statistics.h"
#include "../../../include/embree3/rtcore_compression.h"
#include <cstdint>
#include <memory>

namespace cvert {
class File;
class FileWriter;
} // namespace cvert

namespace embree {
class Device;
class Geometry;

namespace core {
/*! As cbvhSaveSurface. Thread safety: other threads may trace the geometry during this call, but not
 *  commit it. Cost: reads, checksums and writes all blocks. */
void saveGeometry(Geometry* geometry, const char* path);

/*! Writes a file with any number of geometries, for one thread at a time. */
class CompressedFileWriter {
public:
  /*! Starts a file. Errors: as saveGeometry. */
  CompressedFileWriter(Device* device, const char* path);

  /*! As cbvhResumeFileWriter: starts a file, or continues an uncommitted one. key: identifies the source
   *  of the geometries. */
  CompressedFileWriter(Device* device, const char* path, uint64_t key);

  /*! Removes an uncommitted file, unless it has a key and at least one geometry. */
  ~CompressedFileWriter();

  CompressedFileWriter(const CompressedFileWriter&) = delete;
  CompressedFileWriter& operator=(const CompressedFileWriter&) = delete;

  /*! Number of appended geometries, including those of a resumed file. */
  size_t size() const;

  /*! As cbvhAppendSurface. */
  void append(Geometry* geometry);

  /*! As cbvhCommitFileWriter. */
  void commit();

  Device* const device; //!< holds a reference

private:
  std::unique_ptr<cvert::FileWriter> writer;
};

/*! Describes a geometry in a file, as CbvhFileSurfaceInfo does. */
struct CompressedFileGeometryInfo {
  RTCGeometryType type;       //!< of the saved geometry
  RTCCompression compression; //!< representation
  unsigned numPrimitives, numTimeSteps;
  float begin, end; //!< times of the first and last step
  /*! Bounds of everything that rays can hit, at all times; if empty, lower is above upper. */
  float lower[3], upper[3];
  size_t bytes; //!< of tree and blocks in the file
};

/*! An open file, for any number of threads. Loaded geometries keep it mapped. */
class CompressedFile {
public:
  /*! Reads and checks header and directory. Errors: RTC_ERROR_INVALID_ARGUMENT, with the reason. */
  CompressedFile(Device* device, const char* path);
  ~CompressedFile();
  CompressedFile(const CompressedFile&) = delete;
  CompressedFile& operator=(const CompressedFile&) = delete;

  /*! Number of geometries. */
  size_t size() const;

  /*! Reads neither tree nor blocks. Errors: RTC_ERROR_INVALID_ARGUMENT if index is not below size(). */
  CompressedFileGeometryInfo geometryInfo(size_t index) const;

  /*! As cbvhGetFileSurfaceStatistics: members that files do not store are 0. */
  cbvh::CompressionStatistics statistics(size_t index) const;

  /*! As cbvhLoadSurface: returns a new, committed geometry with one reference, which the caller must
   *  release. Copies the blocks that rays reach if another surface has the same surface number, as when an index is
   *  loaded twice. Errors: as geometryInfo; RTC_ERROR_INVALID_ARGUMENT if the tree or a moving block is damaged, or
   *  blocks are not supported; std::bad_alloc; RTC_ERROR_OUT_OF_MEMORY if the memory monitor refuses. */
  Geometry* load(size_t index) const;

  /*! Reads the whole file. Errors: RTC_ERROR_INVALID_ARGUMENT, naming the damaged checksum, tree or block. */
  void verifyAll() const;

  Device* const device; //!< holds a reference

private:
  const std::shared_ptr<const cvert::File> file;
};
} // namespace core
} // namespace embree
