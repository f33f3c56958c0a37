// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Ours has the same file name as Embree's, so the dynamic linker may find another one than intended. */

#include <string>

namespace cbvh {

struct LoadedLibrary
{
  std::string path;
  std::string embreeVersion; // "3.13.5"; empty if it opens no device
  std::string cbvhVersion;   // "0.9.0"; empty for stock Embree

  /* "Embree CBVH 0.9.0 on Embree 3.13.5, /usr/lib/libembree3.so.3" */
  std::string description() const;
};

LoadedLibrary loadedLibrary();

/* Throws Error with the loaded library and a remedy if Embree CBVH's functions are missing. */
void requireCompression();

} // namespace cbvh
