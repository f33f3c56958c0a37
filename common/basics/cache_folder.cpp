// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/cache_folder.h"
#include "basics/error.h"
#include "basics/setting_name.h"

#include <cstdlib>
#include <filesystem>

namespace programs {

std::string userCacheFolder() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::filesystem::path(value ? value : "");
  };
  std::filesystem::path caches = variable("XDG_CACHE_HOME");
  if (!caches.is_absolute()) {
    const std::filesystem::path home = variable("HOME");
    if (!home.is_absolute())
      throw Error("cannot locate the cache folder: neither XDG_CACHE_HOME nor HOME is an absolute path; set one of "
                  "them, or pass " +
                  settingName("map-folder") + " DIR");
    caches = home / ".cache";
  }
  return (caches / "embree-cbvh").string();
}

} // namespace programs
