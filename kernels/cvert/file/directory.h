// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks a file's header and directory. Readers and writers that continue a file use the same checks, so that a file
 * that was continued can be loaded. */

#include "format.h"
#include "../portable/reason.h"
#include <string>

namespace cvert {
/*! Checks the header's kind, byte order, checksum and versions. */
Reason validateHeader(const FileHeader& header);

/*! Checks that the directory is within header.fileBytes, and has at least one record. */
Reason validateDirectoryPlace(const FileHeader& header);

/*! Checks all records, and where trees and blocks are in a file of `bytes` bytes. Does not read trees and blocks.
 *  Throws Error, see failGeometry(). */
void requireDirectory(const std::string& path, const FileGeometry* records, size_t count, uint64_t bytes);

/*! Throws Error with the path and i: geometry i is damaged, or not supported. Throws DAMAGED for all codes but
 *  UNSUPPORTED. where: precedes the reason without a separator. */
[[noreturn]] void failGeometry(const std::string& path, size_t i, const std::string& where, const Reason& reason);
} // namespace cvert
