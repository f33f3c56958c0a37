// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* OpenEXR instead of OpenImageIO, for channels of different types. */

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>

#include <string>

namespace programs {

/* Writes completely or not at all. Throws Error with the path. */
void writeExrFile(const std::string& path, const Imf::Header& header, const Imf::FrameBuffer& frame, int lines);

} // namespace programs
