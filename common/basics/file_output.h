// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Files that appear complete or not at all: written under a temporary name in the same folder, then renamed. Devices,
 * pipes and descriptors such as /dev/stdout are written in place, because a rename would replace them. */

#include <cstdint>
#include <memory>
#include <string>

namespace programs {

/* At most one may exist at a time, because forceExitAfterCancel removes only one. Not thread-safe. */
class PendingFile {
public:
  /* Creates the temporary file. Throws Error, also if this path is an input of the run (input_files.h). */
  explicit PendingFile(const std::string& path);

  /* Removes the temporary file unless it was committed. */
  ~PendingFile();

  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  /* For writers that open the file themselves. Lacks the extension of the final path. */
  const std::string& temporary() const;

  /* Returns false on failure; commit() then throws. `offset` is in bytes. */
  bool write(const void* data, size_t bytes, uint64_t offset) noexcept;

  /* Reason of the first write that failed, or empty. */
  std::string error() const;

  /* Moves the file to its final path and keeps the permissions of a file that it replaces. Throws Error. */
  void commit();

private:
  struct Destination;
  std::string path;
  std::unique_ptr<Destination> destination;
};

/* Creates and removes a file next to `path`, unless it is a device or a pipe. Throws Error. */
void requireWritable(const std::string& path);

/* Throws Error. */
void writeTextFile(const std::string& path, const std::string& text);

/* Writes and flushes. Throws Error, for example if the disk is full. */
void writeStandardOutput(const std::string& text);

/* Creates a folder and its parents if necessary, and a file in it as a test. Throws Error. */
void prepareOutputFolder(const std::string& path);

/* Removes folders that prepareOutputFolder created and that are empty. For programs that fail before they write. */
void removeEmptyOutputFolders();

} // namespace programs
