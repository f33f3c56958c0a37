// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Libraries are opened by path, so equal sonames do not matter. RTLD_LOCAL separates them: each exports only API
 * functions and never calls these itself. With RTLD_DEEPBIND, a library would use a std::cout of its own. */

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

namespace programs {
namespace {

namespace fs = std::filesystem;

constexpr const char* libraryFile = "libembree3.so.3";

std::string fileAt(const std::string& given) {
  const fs::path path = fs::absolute(given);
  if (!fs::is_directory(path)) return path.string();
  for (const char* name : {libraryFile, "libembree3.so"})
    if (fs::exists(path / name)) return (path / name).string();
  throw Error("--library '" + given + "': the folder has no " + libraryFile + ": expected one");
}

class OutputCapture {
public:
  OutputCapture() : before(std::cout.rdbuf(captured.rdbuf())) {}
  ~OutputCapture() { std::cout.rdbuf(before); }
  OutputCapture(const OutputCapture&) = delete;
  OutputCapture& operator=(const OutputCapture&) = delete;

  std::string text() const { return captured.str(); }

private:
  std::ostringstream captured;
  std::streambuf* before;
};

/* Returns instruction sets from a device's verbose output, "SSE2 AVX2  (compile time enabled)", because no API
 * function does. */
std::vector<std::string> parseTargets(const std::string& output) {
  const size_t end = output.find("(compile time enabled)");
  if (end == std::string::npos) return {};
  const size_t begin = output.rfind('\n', end) + 1;
  std::istringstream line(output.substr(begin, end - begin));
  std::vector<std::string> targets;
  for (std::string word; line >> word;) targets.push_back(lowerCase(word));
  return targets;
}

} // namespace

Library::Library() {
  open(libraryFile);
  file = loadedLibrary().path; // where the loader found it
}

Library::Library(const std::string& name, const std::string& path) : label(name) {
  open(path);
  readProperties();
}

void Library::open(const std::string& given) {
  file = label.empty() ? given : fileAt(given);
  opened = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!opened) throw Error((label.empty() ? "" : "--library '" + given + "': ") + std::string(dlerror()));
  functions = embreeFunctionsOf(opened);
  if (!functions.at("rtcNewDevice"))
    throw Error("--library '" + given + "' is not Embree: expected a library with rtcNewDevice");
}

void Library::readProperties() {
  use();
  const OutputCapture output;
  const EmbreeDevice device("verbose=1,threads=1");
  const ssize_t number = rtcGetDeviceProperty(device.handle(), RTC_DEVICE_PROPERTY_VERSION); // for example 31305
  release =
      std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." + std::to_string(number % 100);
  if (number / 10000 != RTC_VERSION_MAJOR)
    throw Error(description() + " is Embree " + release + ": expected Embree " + std::to_string(RTC_VERSION_MAJOR));
  targets = parseTargets(output.text());
}

void Library::use() const { useEmbreeFunctions(functions, description()); }

std::string Library::description() const { return label.empty() ? file : "library " + label + " (" + file + ")"; }

std::vector<Library> openLibraries(const std::vector<std::string>& paths) {
  if (paths.size() > 26)
    throw Error("--library names " + std::to_string(paths.size()) + " libraries: expected at most 26");
  std::vector<Library> libraries;
  for (const std::string& path : paths) {
    Library library(std::string(1, char('A' + libraries.size())), path);
    for (const Library& other : libraries)
      if (library.isSameFile(other))
        throw Error("--library: " + other.path() + " and " + library.path() +
                    " are the same file: expected different files; a library may be compared with a copy of itself");
    libraries.push_back(library);
  }
  return libraries;
}

std::vector<std::string> commonIsas(const std::vector<Library>& libraries) {
  std::vector<std::string> common{"sse2", "sse4.2", "avx", "avx2", "avx512"};
  for (const Library& library : libraries) {
    const std::vector<std::string>& own = library.isas();
    const auto lacks = [&](const std::string& isa) { return std::find(own.begin(), own.end(), isa) == own.end(); };
    if (!own.empty()) common.erase(std::remove_if(common.begin(), common.end(), lacks), common.end());
  }
  if (common.empty()) throw Error("the libraries of --library have no common instruction set: expected at least one");
  return common;
}

} // namespace programs
