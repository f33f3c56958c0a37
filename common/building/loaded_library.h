// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Which Embree a program runs on. Ours has the name of Embree's own library, so the one that the
 * dynamic linker finds first may be another than the one that the program was built with. */

#include <string>

namespace cbvh {

struct LoadedLibrary
{
  std::string path;    // of the file
  std::string release; // of Embree, "3.13.5"; empty where it opens no device
  std::string ours;    // of Embree CBVH, "0.9.0"; empty for a library that has none

  /* "Embree CBVH 0.9.0 on Embree 3.13.5, /usr/lib/libembree3.so.3" */
  std::string description() const;
};

/* The libembree3.so.3 of this process. */
LoadedLibrary loadedLibrary();

/* Throws Error where functions of Embree CBVH are missing, that says which library is loaded and what to do. */
void requireCompression();

} // namespace cbvh
