// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/cache_folder.h"
#include "basics/error.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

namespace cbvh::test {
namespace {

namespace fs = std::filesystem;

/* Sets a variable of the environment, or takes it away, until the end of a test. */
class Variable
{
public:
  Variable(const char* name, const std::optional<std::string>& value) : name(name)
  {
    if (const char* old = std::getenv(name))
      before = old;
    set(value);
  }
  ~Variable() { set(before); }

private:
  void set(const std::optional<std::string>& value)
  {
    if (value)
      setenv(name, value->c_str(), 1);
    else
      unsetenv(name);
  }

  const char* name;
  std::optional<std::string> before;
};

class CacheFolder : public testing::Test
{
protected:
  CacheFolder() { fs::remove_all(folder); }
  ~CacheFolder() override { fs::remove_all(folder); }

  const fs::path folder = fs::path(testing::TempDir()) / "cache_folder_test";
};

TEST_F(CacheFolder, IsWhereTheEnvironmentSaysAndIsMade)
{
  const Variable cache("XDG_CACHE_HOME", (folder / "xdg").string()), home("HOME", (folder / "home").string());
  EXPECT_EQ(userCacheFolder(), (folder / "xdg" / "embree-cbvh").string());
  EXPECT_TRUE(fs::is_directory(folder / "xdg" / "embree-cbvh"));
  EXPECT_FALSE(fs::exists(folder / "home"));
}

TEST_F(CacheFolder, IsAtHomeWithoutAnAbsolutePathInTheEnvironment)
{
  const Variable home("HOME", (folder / "home").string());
  for (const std::optional<std::string>& value : std::vector<std::optional<std::string>>{std::nullopt, "", "caches"})
  {
    const Variable cache("XDG_CACHE_HOME", value);
    EXPECT_EQ(userCacheFolder(), (folder / "home" / ".cache" / "embree-cbvh").string()) << value.value_or("none");
  }
}

TEST_F(CacheFolder, ThatIsNowhereIsAnError)
{
  const Variable cache("XDG_CACHE_HOME", std::nullopt), home("HOME", std::nullopt);
  EXPECT_THROW(userCacheFolder(), Error);
}

TEST_F(CacheFolder, ThatCannotBeMadeIsAnErrorWithItsName)
{
  fs::create_directories(folder);
  std::ofstream(folder / "file") << "no folder";
  const Variable cache("XDG_CACHE_HOME", (folder / "file").string());
  try
  {
    userCacheFolder();
    FAIL() << "no error";
  }
  catch (const Error& e)
  {
    EXPECT_NE(std::string(e.what()).find((folder / "file" / "embree-cbvh").string()), std::string::npos) << e.what();
  }
}

} // namespace
} // namespace cbvh::test
