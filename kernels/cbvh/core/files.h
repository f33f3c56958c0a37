// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed geometries in files. A file is mapped: rays can be traced immediately, blocks that no ray reaches stay on
 * disk, and processes share the memory. docs/formats/file.md describes the format.
 *
 * Paths: an existing file is replaced in one step when the new file is complete, and is unchanged until then. Symbolic
 * links are followed, and the file's permissions are kept. A process that is killed leaves a file next to the path,
 * whose name ends in ".cbvh-part-" and digits; the next save to the same path removes it. A mapped file may be replaced
 * or removed, but must not be written or truncated. */

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
     *  The same if writing fails, for example because the disk is full or a limit on file sizes is reached.
     *  RTC_ERROR_INVALID_ARGUMENT for a path that cannot be written, or that is a device or a pipe. Thread safety:
     *  other threads may trace the geometry during this call, but not commit it. Cost: reads all blocks, writes them
     *  and computes their checksums. */
    void saveGeometry (Geometry* geometry, const char* path);

    /*! Writes a file with any number of geometries. Only one thread at a time may use it. */
    class CompressedFileWriter
    {
    public:
      /*! Starts a file. Errors: as saveGeometry. */
      CompressedFileWriter (Device* device, const char* path);

      /*! Starts a file, or continues one that was not committed. Appended geometries are kept in a file next to the
       *  path, with ".part" added to its name. A continued writer already has its geometries. If the process is killed
       *  or the disk is full, the last geometry is lost, or the last 64 MiB of smaller ones.
       *
       *  key: identifies the source of the geometries, so that files of different sources are not mixed.
       *
       *  Errors: also RTC_ERROR_INVALID_ARGUMENT if the existing file has another key, was started by another version
       *  of the library, is damaged, or is being written by another writer. */
      CompressedFileWriter (Device* device, const char* path, uint64_t key);

      /*! Removes a file that was not committed, or keeps it if the writer has a key. */
      ~CompressedFileWriter ();

      CompressedFileWriter (const CompressedFileWriter&) = delete;
      CompressedFileWriter& operator= (const CompressedFileWriter&) = delete;

      size_t size () const;

      /*! Appends a geometry, which may be released afterwards. After a geometry that cannot be saved, others can be
       *  appended; after a write error none can. Errors: as saveGeometry. */
      void append (Geometry* geometry);

      /*! Completes the file: everything is on the disk, and the file has its name. Requires at least one geometry.
       *  Errors: as saveGeometry. */
      void commit ();

      Device* const device;  //!< referenced

    private:
      std::unique_ptr<cvert::FileWriter> writer;
    };

    /*! Description of a geometry in a file's directory. */
    struct FileDescription
    {
      RTCGeometryType type;                    //!< type of the saved geometry
      RTCCompression compression;              //!< compression of the saved geometry
      unsigned primitiveCount, timeStepCount;
      float begin, end;                        //!< times of the first and the last step
      /*! Bounds of everything that rays can hit, at all times. Empty if lower is above upper. */
      float lower[3], upper[3];
      size_t bytes;                            //!< size in the file
    };

    /*! An open file. Any number of threads may use it. Loaded geometries keep it mapped. */
    class CompressedFile
    {
    public:
      /*! Reads and checks the header and the directory. Errors: RTC_ERROR_INVALID_ARGUMENT, with the reason, if the
       *  path is not a regular file, or if the file has another format or an unsupported version, or is truncated or
       *  altered. */
      CompressedFile (Device* device, const char* path);
      ~CompressedFile ();
      CompressedFile (const CompressedFile&) = delete;
      CompressedFile& operator= (const CompressedFile&) = delete;

      size_t size () const;

      /*! Describes a geometry without reading its tree or its blocks. Errors: RTC_ERROR_INVALID_ARGUMENT if index is
       *  not below size(). */
      FileDescription describe (size_t index) const;

      /*! Returns the statistics of one geometry. Errors: as describe. */
      cbvh::CompressionStatistics statistics (size_t index) const;

      /*! Returns a new, committed geometry with one reference, which the caller must release. It has blocks but not the
       *  input that they were built from. It can be attached, instanced, traced and saved; all other functions fail
       *  with RTC_ERROR_INVALID_OPERATION.
       *
       *  Reads and checks the tree, and for moving geometry also the blocks. Other blocks are checked when rays first
       *  reach them: damaged blocks are left out, and the device reports the first one. If two geometries of the same
       *  index exist at a time, the second has private copies of the blocks that rays reach.
       *
       *  Errors: as describe; RTC_ERROR_INVALID_ARGUMENT if the tree is damaged; std::bad_alloc. */
      Geometry* load (size_t index) const;

      /*! Reads the whole file. Errors: RTC_ERROR_INVALID_ARGUMENT if a checksum, a tree or a block is damaged; the
       *  message names it. */
      void verifyAll () const;

      Device* const device;  //!< referenced

    private:
      const std::shared_ptr<const cvert::File> file;
    };
  }
}
