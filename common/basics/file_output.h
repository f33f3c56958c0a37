// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Files that are there whole or not at all: written under a temporary name beside
 * the final one, then renamed. */

#include <string>

namespace cbvh {

/* One at a time: that is what a cancelled program removes, see endSoonAfterCancel. */
class PendingFile
{
public:
  explicit PendingFile(const std::string& path);

  /* Removes the temporary file if it was not committed. */
  ~PendingFile();

  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  /* Same folder and extension as the final file: writers choose their format by it. */
  const std::string& temporary() const { return temp; }

  /* Gives the file its name. Throws Error. */
  void commit();

private:
  std::string final, temp;
  bool done = false;
};

/* Writes a text. Throws Error. */
void writeTextFile(const std::string& path, const std::string& text);

/* Writes a text to standard output, all of it. Throws Error, on a full disk for one. */
void writeStandardOutput(const std::string& text);

/* Makes a folder and its parents and sees that files can be made in it. Throws Error. */
void prepareOutputFolder(const std::string& path);

} // namespace cbvh
