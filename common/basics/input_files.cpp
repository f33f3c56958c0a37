// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/input_files.h"
#include "basics/error.h"

#include <map>
#include <mutex>
#include <sys/stat.h>
#include <utility>

namespace programs {
namespace {

using FileIdentity = std::pair<dev_t, ino_t>;

std::mutex mutex;
std::map<FileIdentity, std::string> inputs; // the path under which the file was read

/* Returns false unless this is a regular file; others are never replaced. */
bool findIdentity(const std::string& path, FileIdentity& identity) {
  struct stat status;
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
  identity = {status.st_dev, status.st_ino};
  return true;
}

} // namespace

void recordInputFile(const std::string& path) {
  FileIdentity identity;
  if (!findIdentity(path, identity)) return;
  const std::lock_guard<std::mutex> lock(mutex);
  inputs[identity] = path;
}

void requireNoInputFile(const std::string& path) {
  FileIdentity identity, now;
  if (!findIdentity(path, identity)) return;
  const std::lock_guard<std::mutex> lock(mutex);
  const auto found = inputs.find(identity);
  /* The inode of a removed file may belong to another file now. */
  if (found == inputs.end() || !findIdentity(found->second, now) || now != identity) return;
  const std::string input =
      found->second == path ? "an input of this run" : found->second + ", an input of this run, which is the same file";
  throw Error(path + ": would replace " + input + ": expected another name");
}

} // namespace programs
