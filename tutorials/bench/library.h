// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A build of Embree's library in this process, of which there may be several. */

#include "embree_calls.h"

#include <string>
#include <vector>

namespace cbvh {

class Library
{
public:
  /* The program's own, where the loader finds it. It has no name. */
  Library();

  /* name: in tables and records. path: of libembree3.so.3, or of a folder that has one. Is in
   * use afterwards. Throws Error for a file that is no Embree 3. */
  Library(const std::string& name, const std::string& path);

  /* All that the program calls of Embree is this library's from now on. What a library made
   * is for its own functions only. No other thread calls Embree meanwhile. */
  void use() const;

  const std::string& name() const { return label; }
  const std::string& path() const { return file; }
  const std::string& version() const { return release; }                // "3.13.5"; "" without a name, as isas
  const std::vector<std::string>& isas() const { return targets; }      // that it was built for; empty if it does not say
  bool compresses() const { return functions.at("rtcSetGeometryCompression"); }
  bool isSameFile(const Library& other) const { return opened == other.opened; }

  /* For messages: "library A (FILE)", or "libembree3.so.3". */
  std::string description() const;

private:
  void open(const std::string& given);
  void ask();

  std::string label, file, release;
  std::vector<std::string> targets;
  void* opened = nullptr; // until the process ends: threads may hold what is Embree's
  EmbreeFunctions functions;
};

/* Libraries called A, B and so on, each another file. Throws Error. */
std::vector<Library> openLibraries(const std::vector<std::string>& paths);

/* The instruction sets that none of them says it lacks, narrowest first. Throws Error if there
 * is none. */
std::vector<std::string> commonIsas(const std::vector<Library>& libraries);

} // namespace cbvh
