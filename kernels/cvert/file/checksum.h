// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checksum of all parts of a file of compressed surfaces. */

#include <cstddef>
#include <cstdint>

namespace cvert {
/*! CRC-32C, as in iSCSI. before: checksum of the preceding bytes, to compute a checksum in pieces. isPortable: uses
 *  tables instead of the processor's instruction, for tests. */
uint32_t fileChecksum(const void* data, size_t bytes, uint32_t before = 0, bool isPortable = false);
} // namespace cvert
