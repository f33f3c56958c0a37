// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The spelling of scene settings in messages: --frame-level in programs, frame_level in the Python module. */

#include <string>

namespace programs {

enum class SettingNames {
  Options,  // --frame-level
  Arguments // frame_level
};

/* Not thread-safe: call it first. */
void setSettingNames(SettingNames names);

/* `words` is in lower case with hyphens, "frame-level". */
std::string settingName(const std::string& words);

} // namespace programs
