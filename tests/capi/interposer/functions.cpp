// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares all functions that Embree's headers name with the tables of the interposer, and with the functions that the
 * interposer overrides.
 *
 *   functions INTERPOSER FOLDER-OF-HEADERS */

#include "kernels/interposer/functions.h"

#include <cstdio>
#include <dlfcn.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>

namespace {

unsigned failures = 0;
void fail(const std::string& function, const char* error) {
  std::fprintf(stderr, "%s: %s\n", function.c_str(), error);
  failures++;
}

/* Whether the tables list a function as overridden. */
std::map<std::string, bool> readTables() {
  std::map<std::string, bool> functions;
  for (const bool isOverridden : {false, true})
    for (const interposer::Functions& group :
         isOverridden ? interposer::overriddenFunctions : interposer::otherFunctions)
      for (const char* const name : group.names)
        if (!functions.insert({name, isOverridden}).second) fail(name, "the tables contain it twice");
  return functions;
}

std::set<std::string> readHeaders(const char* folder) {
  std::set<std::string> names;
  const std::regex name("\\brtc[A-Z]\\w*");
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    std::ifstream stream(file.path());
    const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    for (std::sregex_iterator match(text.begin(), text.end(), name), end; match != end; ++match)
      names.insert(match->str());
  }
  return names;
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  void* const library = dlopen(argv[1], RTLD_LAZY | RTLD_LOCAL);
  if (!library) {
    std::fprintf(stderr, "%s\n", dlerror());
    return 2;
  }
  const std::map<std::string, bool> tables = readTables();
  const std::set<std::string> declared = readHeaders(argv[2]);
  if (declared.size() < 100) fail(argv[2], "expected a folder with the headers of Embree 4");
  for (const std::string& function : declared)
    if (tables.count(function) == 0) fail(function, "it is in the headers, but not in kernels/interposer/functions.h");
  for (const auto& entry : tables)
    if ((dlsym(library, entry.first.c_str()) != nullptr) != entry.second)
      fail(entry.first, entry.second ? "the interposer does not override it" : "the interposer overrides it");
  std::printf("%zu functions in the headers, %zu in the tables, %u failures\n", declared.size(), tables.size(),
              failures);
  return failures ? 1 : 0;
}
