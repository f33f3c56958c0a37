// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The files that a run reads, so that none of its outputs replaces one of them. Safe in any thread. */

#include <string>

namespace cbvh {

/* Remembers a file by its device and inode, if there is one. */
void noteInputFile(const std::string& path);

/* Throws Error, which names both, if output to a path would replace a file that was noted and is still there. */
void requireNoInputFile(const std::string& path);

} // namespace cbvh
