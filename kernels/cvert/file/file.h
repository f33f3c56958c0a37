// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A file of compressed surfaces, mapped for reading. Opening checks header and directory. TreeReader checks trees;
 * validateVertBlock and validateMeshBlock check blocks. The file may be replaced or removed while it is mapped, but
 * must not be written to or truncated: reading a truncated file ends the process with SIGBUS. */

#include "../portable/reason.h"
#include "format.h"
#include <functional>
#include <string>

namespace cvert {
/*! Immutable; any number of threads may read it. */
class File {
public:
  /*! Throws Error with the path: INVALID_ARGUMENT if the file cannot be opened and mapped or is shorter than a
   *  header, DAMAGED or UNSUPPORTED for its header and directory. */
  explicit File(const std::string& path);
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  /*! Number of geometries. */
  size_t size() const { return header()->numGeometries; }

  /* References and pointers are valid while this object exists. */
  const FileGeometry& geometry(size_t i) const { return ((const FileGeometry*)(data + header()->directory))[i]; }
  const char* tree(size_t i) const { return data + geometry(i).tree; }
  const char* blocks(size_t i) const { return data + geometry(i).blocks; }

  /*! Validates a FILE_FRAMED block, including its surface number. bytes: from the block to the end of the geometry's
   *  blocks. */
  typedef std::function<Reason(const FileGeometry& record, const void* block, size_t bytes)> BlockCheck;

  /*! Reads the whole file. Throws Error if a checksum differs, or a tree or block is damaged or not supported. other:
   *  for FILE_FRAMED blocks; without it only their checksum is compared. */
  void verify(const BlockCheck& other = BlockCheck()) const {
    for (size_t i = 0; i < size(); i++) verifyGeometry(i, other);
  }

  /* Throw Error with the path and i: geometry i is damaged, or not supported. fail() throws DAMAGED for all codes but
   * UNSUPPORTED. where: precedes the reason without a separator. */
  [[noreturn]] void fail(size_t i, const std::string& where, const Reason& reason) const;
  [[noreturn]] void failDamaged(size_t i, const std::string& why) const;
  [[noreturn]] void failUnsupported(size_t i, const std::string& why) const;

  /*! Owned by this object. */
  int descriptor() const { return file; }

  const std::string path;

private:
  const FileHeader* header() const { return (const FileHeader*)data; }
  void map();
  void unmap();
  Reason validate() const;
  void verifyGeometry(size_t i, const BlockCheck& other) const;

  int file;
  const char* data = nullptr;
  uint64_t bytes = 0;
};
} // namespace cvert
