// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The spelling of scene settings in messages. Programs and the Python module share code, but a program's option is
 * --frame-level and the Python argument is frame_level. */

#include <string>

namespace cbvh {

enum class SettingNames
{
  Options,  // --frame-level
  Arguments // frame_level
};

/* The default is Options. Not thread-safe: a program calls it before anything else. */
void setSettingNames(SettingNames names);

/* Returns a setting as the user spells it. `words` is in lower case with hyphens: "frame-level". */
std::string settingName(const std::string& words);

} // namespace cbvh
