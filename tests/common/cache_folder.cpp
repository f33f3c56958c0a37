// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/cache_folder.h"
#include "basics/error.h"

#include <cstdlib>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

namespace programs::test { namespace {

/* Sets or unsets an environment variable until the end of a test. */
class Variable {
public:
  Variable(const char* name, const std::optional<std::string>& value) : name(name) {
    if (const char* old = std::getenv(name)) before = old;
    set(value);
  }
  ~Variable() { set(before); }

private:
  void set(const std::optional<std::string>& value) {
    if (value) setenv(name, value->c_str(), 1);
    else unsetenv(name);
  }

  const char* name;
  std::optional<std::string> before;
};

TEST(CacheFolder, IsNamedByTheEnvironment) {
  const Variable cache("XDG_CACHE_HOME", "/some/caches"), home("HOME", "/home/user");
  EXPECT_EQ(userCacheFolder(), "/some/caches/embree-cbvh");
}

TEST(CacheFolder, IsInHomeWithoutAnAbsolutePathInTheEnvironment) {
  const Variable home("HOME", "/home/user");
  for (const std::optional<std::string>& value : std::vector<std::optional<std::string>>{std::nullopt, "", "caches"}) {
    const Variable cache("XDG_CACHE_HOME", value);
    EXPECT_EQ(userCacheFolder(), "/home/user/.cache/embree-cbvh") << value.value_or("none");
  }
}

TEST(CacheFolder, MissingFolderIsAnError) {
  const Variable cache("XDG_CACHE_HOME", std::nullopt), home("HOME", std::nullopt);
  EXPECT_THROW(userCacheFolder(), Error);
}

}} // namespace programs::test
