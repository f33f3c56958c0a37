// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Identifies the library in use: ours and Embree's have the same file name, so the dynamic linker may find either. */

#include <string>

namespace programs {

struct LoadedLibrary {
  std::string path;
  std::string embreeVersion; // "3.13.5"; empty if it opens no device
  std::string cbvhVersion;   // "1.0.0"; empty for stock Embree

  /* "Embree CBVH 1.0.0 on Embree 3.13.5, /usr/lib/libembree3.so.3" */
  std::string description() const;
};

/* All members are empty if no library is loaded. */
LoadedLibrary loadedLibrary();

/* Throws Error with the loaded library and a remedy if Embree CBVH's functions are missing. */
void requireCompression();

} // namespace programs
