// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

namespace programs {

/* How a map continues outside of its image. */
enum class TextureWrap {
  Clamp,  // the nearest texel
  Repeat, // copies of the image
  Black,  // 0
};

/* In the order of TextureWrap. */
inline const std::vector<std::string>& textureWrapNames() {
  static const std::vector<std::string> names{"clamp", "repeat", "black"};
  return names;
}

} // namespace programs
