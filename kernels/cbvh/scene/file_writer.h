// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writes a file of compressed surfaces, one after the other. It comes to have its name when all is written, in one step: until then what was
 * there under that name stays. */

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
      /*! Throws where the folder takes no file. */
      explicit FileWriter (const std::string& path);

      /*! Takes what was written away, if it was not committed. */
      ~FileWriter ();

      FileWriter (const FileWriter&) = delete;
      FileWriter& operator= (const FileWriter&) = delete;

      /*! Appends a geometry that was compressed. Throws where it cannot be saved, or the disk is full: then the file is lost. */
      void add (const CompressibleGeometry* geometry, const SurfaceBlocks& blocks);

      /*! All is written, to the disk, and gets its name. */
      void commit ();

    private:
      void write (const void* data, size_t bytes);
      void padTo (uint64_t alignment);
      [[noreturn]] void fail (const std::string& what);

      /*! so that no two geometries of the file have the same */
      uint32_t numberOf (const FileGeometry& record, bool moves);

      std::string path, temporary;
      int file;
      bool failed = false;
      uint64_t at = 0;
      std::vector<FileGeometry> directory;
      std::set<uint32_t> numbers;
    };
  }
}
