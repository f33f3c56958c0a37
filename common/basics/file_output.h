// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Files that are there whole or not at all: they are written under a temporary name next to the final one, then
 * renamed. What a rename would destroy is written into instead: devices, pipes, and descriptors of the process such as
 * /dev/stdout. */

#include <cstdint>
#include <memory>
#include <string>

namespace cbvh {

/* One at a time: that is what a cancelled program removes, see endSoonAfterCancel. */
class PendingFile
{
public:
  /* Throws Error, also if an input of the run has this path, see input_files.h. */
  explicit PendingFile(const std::string& path);

  /* Removes the temporary file if it was not committed. */
  ~PendingFile();

  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  /* Name for writers that open the file themselves. It has no extension. */
  const std::string& temporary() const;

  /* Returns false where that fails. commit() then throws, so nobody else has to look. Throws nothing itself. */
  bool write(const void* data, size_t bytes, uint64_t offset) noexcept;

  /* Of the first write that failed, in words; empty for none. */
  std::string error() const;

  /* Gives the file its name, with the permissions of the file that it replaces. Throws Error. */
  void commit();

private:
  struct Place;
  std::string path;
  std::unique_ptr<Place> place;
};

/* Writes a text. Throws Error. */
void writeTextFile(const std::string& path, const std::string& text);

/* Writes a text to standard output, all of it. Throws Error, on a full disk for one. */
void writeStandardOutput(const std::string& text);

/* Makes a folder and its parents and sees that files can be made in it. Throws Error. */
void prepareOutputFolder(const std::string& path);

} // namespace cbvh
