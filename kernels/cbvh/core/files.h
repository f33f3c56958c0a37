// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed geometries in files. A file is mapped, not read: rays are traced at once, blocks that no ray meets stay on
 * disk, and all processes of a machine share the memory of one file. docs/formats/file.md describes the format.
 *
 * Paths: a file that exists under the path is replaced in one step when all is written; whatever happens before, it
 * stays as it was. Symbolic links are followed, and the file's permissions are kept. A process that is killed leaves a
 * file next to it, whose name goes on with ".cbvh-part-" and digits, which the next save to the same path removes. A
 * file that is mapped may be replaced or removed, but not written into or cut. */

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
    /*! Saves one geometry: its blocks, tree, time steps, primitives and statistics, but not its mask, filters, user
     *  data, vertex attributes and cage.
     *
     *  Errors: RTC_ERROR_INVALID_OPERATION for a geometry without blocks, one that does not ask for compression, was
     *  changed since it was committed, or is not stored as blocks as a whole (faces of edge rates that only GRID
     *  supports), and if writing fails, as on a full disk or at a limit on file sizes; RTC_ERROR_INVALID_ARGUMENT for a
     *  path that cannot be written, or leads to a device or a pipe. Thread safety: the geometry may be traced
     *  meanwhile, but not committed. Cost: reads all blocks, writes them with their checksums. */
    void saveGeometry (Geometry* geometry, const char* path);

    /*! A file that is written, with any number of geometries. One thread may use it at a time. */
    class CompressedFileWriter
    {
    public:
      /*! Begins a file. Errors: as saveGeometry. */
      CompressedFileWriter (Device* device, const char* path);

      /*! Begins a file, or goes on with one that was not committed: what is appended is kept next to the file, under
       *  its name with ".part" after it. The writer then has its geometries already. A process that is killed, and a
       *  disk that is full, lose the last geometry, or the last 64 MiB of smaller ones.
       *
       *  key: a number for what the geometries are made from, so that files of different input are not mixed.
       *
       *  Errors: also RTC_ERROR_INVALID_ARGUMENT if the file that was begun has another key, was begun by another
       *  version of the library, is damaged, or while another writer has it. */
      CompressedFileWriter (Device* device, const char* path, uint64_t key);

      /*! Removes what was not committed, or keeps it if the writer has a key. */
      ~CompressedFileWriter ();

      CompressedFileWriter (const CompressedFileWriter&) = delete;
      CompressedFileWriter& operator= (const CompressedFileWriter&) = delete;

      /*! Returns the number of geometries. */
      size_t size () const;

      /*! Appends a geometry, which may be released then. A geometry that cannot be saved is left out, and others may
       *  follow; after writing failed none can. Errors: as saveGeometry. */
      void append (Geometry* geometry);

      /*! Ends the file: all is on the disk, and has its name. It needs at least one geometry. Errors: as saveGeometry.
       *  */
      void commit ();

      Device* const device;  //!< referenced

    private:
      std::unique_ptr<cvert::FileWriter> writer;
    };

    /*! What a file's directory says of a geometry. */
    struct FileDescription
    {
      RTCGeometryType type;                    //!< that it was made as
      RTCCompression compression;              //!< that it was stored as
      unsigned primitiveCount, timeStepCount;
      float begin, end;                        //!< times of the first step and of the last
      /*! Of all that a ray may hit, at all times; lower is above upper if that is nothing */
      float lower[3], upper[3];
      size_t bytes;                            //!< in the file
    };

    /*! A file that is open. Any number of threads may use it. Geometries that were loaded keep it mapped. */
    class CompressedFile
    {
    public:
      /*! Reads and checks the header and the directory. Errors: RTC_ERROR_INVALID_ARGUMENT, with the reason, if the
       *  path is no regular file, or the file is foreign, truncated, altered or of an unsupported version. */
      CompressedFile (Device* device, const char* path);
      ~CompressedFile ();
      CompressedFile (const CompressedFile&) = delete;
      CompressedFile& operator= (const CompressedFile&) = delete;

      /*! Returns the number of geometries. */
      size_t size () const;

      /*! Describes a geometry, without reading its tree or its blocks. Errors: RTC_ERROR_INVALID_ARGUMENT if index is
       *  not below size(). */
      FileDescription describe (size_t index) const;

      /*! Returns the statistics of the geometry alone. Errors: as describe. */
      cbvh::CompressionStatistics statistics (size_t index) const;

      /*! Returns a new geometry, committed, with one reference, which the caller releases. It has blocks, and nothing
       *  that they were made from: it can be attached, instanced, traced and saved, and refuses anything else with
       *  RTC_ERROR_INVALID_OPERATION.
       *
       *  Reads and checks the tree; of a geometry that moves also the blocks. Other blocks are checked one by one when
       *  rays first meet them: a damaged block is left out, and the device reports the first. Of two geometries of the
       *  same index that exist at a time the second has copies of the blocks that rays meet.
       *
       *  Errors: as describe; RTC_ERROR_INVALID_ARGUMENT if the tree is damaged; std::bad_alloc. */
      Geometry* load (size_t index) const;

      /*! Reads all of the file. Errors: RTC_ERROR_INVALID_ARGUMENT with what is damaged: a checksum, a tree or a block.
       *  */
      void verifyAll () const;

      Device* const device;  //!< referenced

    private:
      const std::shared_ptr<const cvert::File> file;
    };
  }
}
