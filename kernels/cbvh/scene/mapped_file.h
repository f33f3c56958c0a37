// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A file of compressed surfaces, mapped. Opening it reads the header and the directory; a geometry's tree is read, and checked, when that is
 * loaded, its blocks when rays meet them (mapped_blocks.h). */

#include "file_format.h"
#include <memory>
#include <string>

namespace embree
{
  class Device;
  struct SurfaceBlocks;

  namespace cbvh
  {
    class MappedFile
    {
    public:
      /*! Throws, with the reason, where there is no file, or one that is none of these. */
      explicit MappedFile (const std::string& path);
      ~MappedFile ();
      MappedFile (const MappedFile&) = delete;
      MappedFile& operator= (const MappedFile&) = delete;

      size_t size () const { return header()->numGeometries; }
      const FileGeometry& geometry (size_t i) const { return ((const FileGeometry*)(data+header()->directory))[i]; }

      /*! The blocks of a geometry, and the tree above them. Throws where the tree is damaged, or a block of a surface that moves. */
      static std::shared_ptr<const SurfaceBlocks> load (const std::shared_ptr<const MappedFile>& file, Device* device, size_t i);

      /*! Reads all. Throws where a checksum says that something was altered, or a block is none. */
      static void verifyAll (const std::shared_ptr<const MappedFile>& file, Device* device);

      const std::string path;

    private:
      friend class SurfaceLoader;

      const FileHeader* header () const { return (const FileHeader*)data; }
      std::string errorOf () const;
      std::string errorOf (const FileGeometry& geometry) const;

      int file;
      const char* data = nullptr;
      size_t bytes = 0;
    };
  }
}
