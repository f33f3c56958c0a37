// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/exr_levels.h"

#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartInputFile.h>

#include <exception>

namespace programs {

bool hasRipMaps(const std::string& path) try {
  const Imf::MultiPartInputFile file(path.c_str());
  for (int part = 0; part < file.parts(); part++) {
    const Imf::Header& header = file.header(part);
    if (header.hasTileDescription() && header.tileDescription().mode == Imf::RIPMAP_LEVELS) return true;
  }
  return false;
} catch (const std::exception&) { return false; }

} // namespace programs
