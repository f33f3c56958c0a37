// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How messages name the settings of a scene. The same code serves programs, whose users write --frame-level, and the Python
 * module, whose users write frame_level. */

#include <string>

namespace cbvh {

enum class SettingNames
{
  Options,  // --frame-level
  Arguments // frame_level
};

/* The default is Options. Not thread-safe: a program sets it before it does anything else. */
void setSettingNames(SettingNames names);

/* Returns the name of a setting as the user writes it. words: in lower case, with hyphens between, "frame-level". */
std::string settingName(const std::string& words);

} // namespace cbvh
