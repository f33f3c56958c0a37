// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Files that a process has opened. Objects from files are pickled as the path of the file, and all copies of a pickle
 * in a process share one object, which is mapped once. */

#include "basics/error.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <sys/stat.h>
#include <tuple>

namespace programs::python {

template<typename T>
class OpenFiles {
public:
  /* Those of this process. Members are thread-safe, and throw Error if there is no such file. */
  static OpenFiles& ofProcess() {
    static OpenFiles files;
    return files;
  }

  /* Lets find() return this object, unless it knows another one of the file. */
  void add(const std::filesystem::path& path, const std::shared_ptr<T>& opened) {
    const Identity identity = identityOf(path);
    const std::lock_guard<std::mutex> lock(mutex);
    std::weak_ptr<T>& entry = files[identity];
    if (entry.expired()) entry = opened;
  }

  /* Returns the object of the file if somebody still has it, otherwise null. A file that was replaced is another one.
   */
  std::shared_ptr<T> find(const std::filesystem::path& path) {
    const Identity identity = identityOf(path);
    const std::lock_guard<std::mutex> lock(mutex);
    for (auto i = files.begin(); i != files.end();) i = i->second.expired() ? files.erase(i) : std::next(i);
    const auto found = files.find(identity);
    return found == files.end() ? nullptr : found->second.lock();
  }

private:
  OpenFiles() = default;

  /* Device, inode, size, and time of the last change. */
  using Identity = std::tuple<dev_t, ino_t, off_t, time_t, long>;

  static Identity identityOf(const std::filesystem::path& path) {
    struct stat s;
    if (stat(path.c_str(), &s) != 0) throw Error(path.string() + ": " + std::strerror(errno));
    return {s.st_dev, s.st_ino, s.st_size, s.st_mtim.tv_sec, s.st_mtim.tv_nsec};
  }

  std::mutex mutex; // protects the member below
  std::map<Identity, std::weak_ptr<T>> files;
};

} // namespace programs::python
