// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A library is opened by its path, so another file is another library, though all have the
 * same name inside. RTLD_LOCAL keeps them apart: each finds its own functions, of which it
 * exports those of the API only and calls none of these itself. Without RTLD_DEEPBIND, by
 * which it would find a std::cout that is not this program's. */

#include "library.h"
#include "basics/error.h"
#include "basics/text.h"
#include "building/embree_device.h"
#include "building/loaded_library.h"

#include <algorithm>
#include <dlfcn.h>
#include <filesystem>
#include <iostream>
#include <sstream>

namespace cbvh {
namespace {

namespace fs = std::filesystem;

constexpr const char* libraryFile = "libembree3.so.3";

std::string fileAt(const std::string& given)
{
  const fs::path path = fs::absolute(given);
  if (!fs::is_directory(path))
    return path.string();
  for (const char* name : {libraryFile, "libembree3.so"})
    if (fs::exists(path / name))
      return (path / name).string();
  throw Error("--library '" + given + "': the folder has no " + libraryFile);
}

/* What is written on std::cout meanwhile. */
class Listener
{
public:
  Listener() : before(std::cout.rdbuf(heard.rdbuf())) {}
  ~Listener() { std::cout.rdbuf(before); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  std::string text() const { return heard.str(); }

private:
  std::ostringstream heard;
  std::streambuf* before;
};

/* From what a device says of itself, "SSE2 AVX2  (compile time enabled)", names as --isa has
 * them: no function returns it. */
std::vector<std::string> targetsIn(const std::string& said)
{
  const size_t end = said.find("(compile time enabled)");
  if (end == std::string::npos)
    return {};
  const size_t begin = said.rfind('\n', end) + 1;
  std::istringstream line(said.substr(begin, end - begin));
  std::vector<std::string> targets;
  for (std::string word; line >> word;)
    targets.push_back(lowerCase(word));
  return targets;
}

} // namespace

Library::Library()
{
  open(libraryFile);
  file = loadedLibrary().path; // the one that was found
}

Library::Library(const std::string& name, const std::string& path) : label(name)
{
  open(path);
  ask();
}

void Library::open(const std::string& given)
{
  file = label.empty() ? given : fileAt(given);
  opened = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!opened)
    throw Error((label.empty() ? "" : "--library '" + given + "': ") + std::string(dlerror()));
  functions = embreeFunctionsOf(opened);
  if (!functions.at("rtcNewDevice"))
    throw Error("--library '" + given + "' is no Embree: it has no rtcNewDevice");
}

void Library::ask()
{
  use();
  const Listener listener;
  const EmbreeDevice device("verbose=1,threads=1");
  const ssize_t number = rtcGetDeviceProperty(device.handle(), RTC_DEVICE_PROPERTY_VERSION); // 31305
  release = std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." + std::to_string(number % 100);
  if (number / 10000 != RTC_VERSION_MAJOR)
    throw Error(description() + " is Embree " + release + ", and not " + std::to_string(RTC_VERSION_MAJOR));
  targets = targetsIn(listener.text());
}

void Library::use() const
{
  useEmbreeFunctions(functions, description());
}

std::string Library::description() const
{
  return label.empty() ? file : "library " + label + " (" + file + ")";
}

std::vector<Library> openLibraries(const std::vector<std::string>& paths)
{
  if (paths.size() > 26)
    throw Error("--library names " + std::to_string(paths.size()) + " libraries, 26 are the most");
  std::vector<Library> libraries;
  for (const std::string& path : paths)
  {
    Library library(std::string(1, char('A' + libraries.size())), path);
    for (const Library& other : libraries)
      if (library.isSameFile(other))
        throw Error("--library: " + other.path() + " and " + library.path() +
                    " are the same file; to compare a library with itself, copy it");
    libraries.push_back(library);
  }
  return libraries;
}

std::vector<std::string> commonIsas(const std::vector<Library>& libraries)
{
  std::vector<std::string> common{"sse2", "sse4.2", "avx", "avx2", "avx512"};
  for (const Library& library : libraries)
  {
    const std::vector<std::string>& own = library.isas();
    const auto lacks = [&](const std::string& isa) { return std::find(own.begin(), own.end(), isa) == own.end(); };
    if (!own.empty())
      common.erase(std::remove_if(common.begin(), common.end(), lacks), common.end());
  }
  if (common.empty())
    throw Error("the libraries of --library have no instruction set in common");
  return common;
}

} // namespace cbvh
