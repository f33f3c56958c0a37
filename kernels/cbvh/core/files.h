// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed geometries in files, which are mapped: rays can be traced immediately, blocks that no ray reaches stay on
 * disk, and processes share the memory. docs/formats/file.md describes the format.
 *
 * Paths: an existing file is replaced in one step when the new file is complete, and is unchanged until then. Symbolic
 * links are followed, and the file's permissions are kept. A killed process leaves a file next to the path, named with
 * ".cbvh-part-" and digits at the end; the next save to that path removes it. A mapped file may be replaced or removed,
 * but must not be written or truncated. */

#include "../base/surface_statistics.h"
#include "../../../include/embree3/rtcore_compression.h"
#include <cstdint>
#include <memory>

namespace cvert
{
  class File;
  class FileWriter;
}

namespace embree
{
  class Device;
  class Geometry;

  namespace core
  {
    /*! Saves a geometry: blocks, tree, time steps, primitives and statistics, but not its mask, filters, user data,
     *  vertex attributes and input.
     *
     *  Errors: RTC_ERROR_INVALID_OPERATION for a geometry that has no blocks, does not request compression, changed
     *  since its last commit, or is not completely stored as blocks because only GRID supports some of its edge rates.
     *  The same if writing fails, for example on a full disk. RTC_ERROR_INVALID_ARGUMENT for a path that cannot be
     *  written, or is a device or a pipe. Thread safety: other threads may trace the geometry during this call, but not
     *  commit it. Cost: reads, checksums and writes all blocks. */
    void saveGeometry (Geometry* geometry, const char* path);

    /*! Writes a file with any number of geometries. Only one thread at a time may use it. */
    class CompressedFileWriter
    {
    public:
      /*! Starts a file. Errors: as saveGeometry. */
      CompressedFileWriter (Device* device, const char* path);

      /*! Starts a file, or continues one that was not committed, with its geometries. They are stored next to the path,
       *  with ".part" added to the name. A killed process or a full disk loses the last geometry, or the last 64 MiB of
       *  smaller ones.
       *
       *  key: identifies the source of the geometries, to prevent mixing sources.
       *
       *  Errors: also RTC_ERROR_INVALID_ARGUMENT if the existing file has another key, was started by another version
       *  of the library, is damaged, or is being written by another writer. */
      CompressedFileWriter (Device* device, const char* path, uint64_t key);

      /*! Removes an uncommitted file, or keeps it if the writer has a key. */
      ~CompressedFileWriter ();

      CompressedFileWriter (const CompressedFileWriter&) = delete;
      CompressedFileWriter& operator= (const CompressedFileWriter&) = delete;

      size_t size () const;

      /*! Appends a geometry, which may be released afterwards. If a geometry cannot be saved, others still can; after a
       *  write error none can. Errors: as saveGeometry. */
      void append (Geometry* geometry);

      /*! Completes the file: writes it to disk and gives it its name. Requires at least one geometry. Errors: as
       *  saveGeometry. */
      void commit ();

      Device* const device;  //!< referenced

    private:
      std::unique_ptr<cvert::FileWriter> writer;
    };

    /*! Entry of a file's directory. */
    struct FileDescription
    {
      RTCGeometryType type;                    //!< of the saved geometry
      RTCCompression compression;              //!< of the saved geometry
      unsigned primitiveCount, timeStepCount;
      float begin, end;                        //!< times of the first and last step
      /*! Bounds of everything that rays can hit, at all times; empty if lower is above upper. */
      float lower[3], upper[3];
      size_t bytes;                            //!< in the file
    };

    /*! An open file. Any number of threads may use it. Loaded geometries keep it mapped. */
    class CompressedFile
    {
    public:
      /*! Reads and checks the header and the directory. Errors: RTC_ERROR_INVALID_ARGUMENT, with the reason, if the
       *  path is not a regular file, or the file has another format or an unsupported version, or is truncated or
       *  altered. */
      CompressedFile (Device* device, const char* path);
      ~CompressedFile ();
      CompressedFile (const CompressedFile&) = delete;
      CompressedFile& operator= (const CompressedFile&) = delete;

      size_t size () const;

      /*! Reads neither tree nor blocks. Errors: RTC_ERROR_INVALID_ARGUMENT if index is not below size(). */
      FileDescription describe (size_t index) const;

      /*! Errors: as describe. */
      cbvh::CompressionStatistics statistics (size_t index) const;

      /*! Returns a new, committed geometry with one reference, which the caller must release. It has blocks but no
       *  input. It can be attached, instanced, traced and saved; all other functions fail with
       *  RTC_ERROR_INVALID_OPERATION.
       *
       *  Reads and checks the tree, and the blocks of moving geometry. Other blocks are checked when rays first reach
       *  them: damaged blocks are left out, and the device reports the first one. If an index is loaded twice, the
       *  second geometry has private copies of the blocks that rays reach.
       *
       *  Errors: as describe; RTC_ERROR_INVALID_ARGUMENT if the tree is damaged; std::bad_alloc. */
      Geometry* load (size_t index) const;

      /*! Reads the whole file. Errors: RTC_ERROR_INVALID_ARGUMENT, naming the checksum, tree or block that is
       *  damaged. */
      void verifyAll () const;

      Device* const device;  //!< referenced

    private:
      const std::shared_ptr<const cvert::File> file;
    };
  }
}
