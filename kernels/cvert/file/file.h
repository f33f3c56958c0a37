// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A file of compressed surfaces, mapped for reading. Opening it checks the header and the directory. Trees and blocks
 * are not read until they are used, see TreeReader and validateVertBlock. */

#include "../basics/reason.h"
#include "format.h"
#include <functional>
#include <string>

namespace cvert
{
  /*! Immutable. Any number of threads may read it. */
  class File
  {
  public:
    /*! Throws Error with a message that names the path if the file does not exist or is not a valid file of compressed
     *  surfaces. */
    explicit File (const std::string& path);
    ~File ();
    File (const File&) = delete;
    File& operator= (const File&) = delete;

    size_t size () const { return header()->numGeometries; }
    const FileGeometry& geometry (size_t i) const { return ((const FileGeometry*)(data+header()->directory))[i]; }

    /*! First byte of the tree and of the blocks of a geometry. */
    const char* tree (size_t i) const { return data+geometry(i).tree; }
    const char* blocks (size_t i) const { return data+geometry(i).blocks; }

    /*! Returns the first error in a block that is not cVERT. record: of its geometry. bytes: from the block to the end
     *  of the blocks. */
    typedef std::function<Reason (const FileGeometry& record, const void* block, size_t bytes)> BlockCheck;

    /*! Reads all bytes of the file. Throws Error if a checksum differs, or if a tree or a block is damaged. other:
     *  checks blocks that are not cVERT; without it only their checksum is compared. */
    void verify (const BlockCheck& other = BlockCheck()) const {
      for (size_t i=0; i<size(); i++) verifyGeometry(i,other);
    }

    /*! Throws Error: geometry i is damaged. */
    [[noreturn]] void failAt (size_t i, const std::string& why) const;

    /*! Throws Error: this program does not support geometry i. */
    [[noreturn]] void failUnsupported (size_t i, const std::string& why) const;

    /*! Open during the lifetime of this object. */
    int descriptor () const { return file; }

    const std::string path;

  private:
    const FileHeader* header () const { return (const FileHeader*)data; }
    void map ();
    void unmap ();
    Reason validate () const;
    void verifyGeometry (size_t i, const BlockCheck& other) const;

    int file;
    const char* data = nullptr;
    uint64_t bytes = 0;
  };
}
