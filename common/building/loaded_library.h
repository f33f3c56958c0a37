// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Identifies the Embree library that a program runs on. Our library has the same name as Embree's, so the dynamic
 * linker may find a different one than the program was built with. */

#include <string>

namespace cbvh {

struct LoadedLibrary
{
  std::string path;    // of the file
  std::string release; // of Embree, "3.13.5"; empty if it opens no device
  std::string ours;    // of Embree CBVH, "0.9.0"; empty for stock Embree

  /* For example "Embree CBVH 0.9.0 on Embree 3.13.5, /usr/lib/libembree3.so.3". */
  std::string description() const;
};

/* Describes the libembree3.so.3 of this process. */
LoadedLibrary loadedLibrary();

/* Throws Error if functions of Embree CBVH are missing. The message names the loaded library and a remedy. */
void requireCompression();

} // namespace cbvh
