// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A build of Embree's library; the process may hold several. */

#include "embree_calls.h"

#include <string>
#include <vector>

namespace programs {

class Library {
public:
  /* The program's own library, without a name. */
  Library();

  /* `name` is for tables and records; `path` is a libembree3.so.3 or a folder that contains one. Makes the library
   * current. Throws Error if the file is not Embree 3. */
  Library(const std::string& name, const std::string& path);

  /* Directs all calls of Embree to this library. Objects belong to the library that made them. No other thread may call
   * Embree during this call. */
  void use() const;

  const std::string& name() const { return label; }
  const std::string& path() const { return file; }
  const std::string& version() const { return release; }           // "3.13.5"; empty without a name
  const std::vector<std::string>& isas() const { return targets; } // at build time; empty if unknown
  bool compresses() const { return functions.at("rtcSetGeometryCompression"); }
  bool isSameFile(const Library& other) const { return opened == other.opened; }

  /* "library A (PATH)", or the path of the program's own library. */
  std::string description() const;

private:
  void open(const std::string& given);
  void readProperties();

  std::string label, file, release;
  std::vector<std::string> targets;
  void* opened = nullptr; // never closed, because threads may hold objects of Embree
  EmbreeFunctions functions;
};

/* Names libraries A, B and so on. Throws Error, also if two paths are the same file. */
std::vector<Library> openLibraries(const std::vector<std::string>& paths);

/* Instruction sets of all libraries, narrowest first; libraries that report none have all. Throws Error if there is
 * none. */
std::vector<std::string> commonIsas(const std::vector<Library>& libraries);

} // namespace programs
