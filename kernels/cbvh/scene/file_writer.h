// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writes a file of compressed surfaces, one after the other. The file gets its name when all of it is written, in one
 * step: until then the file that had the name stays. */

#include "../base/unfinished_file.h"
#include "file_format.h"
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace embree
{
  class CompressibleGeometry;
  struct SurfaceBlocks;

  namespace cbvh
  {
    class FileWriter
    {
    public:
      /*! Throws if the folder or the path accepts no file. */
      explicit FileWriter (const std::string& path);

      /*! Goes on with what such a writer left, or begins. key: of what the geometries are made from. Throws where what is there is of another key, or
       *  another process writes it. */
      FileWriter (const std::string& path, uint64_t key);

      /*! Takes what was written away, if it was not committed; of a writer with a key it stays, to be gone on with. */
      ~FileWriter ();

      FileWriter (const FileWriter&) = delete;
      FileWriter& operator= (const FileWriter&) = delete;

      /*! Appends a geometry that was compressed. Throws where it cannot be saved, or the disk is full: then the file is lost. */
      void add (const CompressibleGeometry* geometry, const SurfaceBlocks& blocks);

      /*! All is written, to the disk, and gets its name. */
      void commit ();

      /*! of geometries that were added, those of writers before included */
      size_t size () const { return directory.size(); }

    private:
      /*! how much may be lost where the process ends */
      static const uint64_t checkpointBytes = uint64_t(64) << 20;

      /*! Opens the file that is written. ending: after the name of the path, for a file that another writer may go on
       *  with; else empty. */
      void open (const std::string& ending);
      void begin ();
      void resume ();

      /*! Puts the directory behind what was written, and both on the disk; then the header says so. */
      void writeDirectory ();

      void write (const void* data, size_t bytes);
      void padTo (uint64_t alignment);
      [[noreturn]] void fail (const std::string& what);

      /*! so that no two geometries of the file have the same */
      uint32_t numberOf (const FileGeometry& record, bool moves);

      const std::string path;
      std::unique_ptr<UnfinishedFile> file; //!< null after commit
      const bool keeps;                     //!< what is not committed
      bool failed = false;
      uint64_t key = 0;
      uint64_t at = 0, saved = 0;         //!< saved: what the header on the disk knows of
      std::vector<FileGeometry> directory;
      std::set<uint32_t> numbers;
    };
  }
}
