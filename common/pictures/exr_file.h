// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Images by OpenEXR, whose channels OpenImageIO would have of one type. */

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>

#include <string>

namespace cbvh {

/* Writes an image of so many lines, whole or not at all. Throws Error with the path. */
void writeExrFile(const std::string& path, const Imf::Header& header, const Imf::FrameBuffer& frame, int lines);

} // namespace cbvh
