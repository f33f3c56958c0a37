// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>

namespace cvert
{
  /*! CRC-32C, as in iSCSI. before: checksum of preceding bytes. isPortable: does not use the CPU's instruction. */
  uint32_t fileChecksum (const void* data, size_t bytes, uint32_t before = 0, bool isPortable = false);
}
