// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Keeps outputs of a run from replacing its inputs. Thread-safe. */

#include <string>

namespace programs {

/* Records a file that the run reads, by device and inode. Ignores missing files, devices and pipes. */
void recordInputFile(const std::string& path);

/* Throws Error with both paths, or one if they are equal, if writing to `path` would replace a recorded file that still
 * exists. */
void requireNoInputFile(const std::string& path);

} // namespace programs
