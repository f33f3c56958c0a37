// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <istream>
#include <memory>
#include <string>

namespace programs {

/* Opens a file, or a pipe that a program opens for writing within 10 seconds. Throws Error for devices, which may have
 * no end, and for anything else that cannot be read. Reading may throw Error, Canceled and std::ios_base::failure from
 * rdbuf(); the stream itself would only set badbit. */
std::unique_ptr<std::istream> openInput(const std::string& path);

} // namespace programs
