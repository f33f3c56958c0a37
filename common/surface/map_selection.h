// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Finds the image and the channel of a file that are the map. */

#include "surface/map_image.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <system_error>
#include <vector>

namespace programs {

/* Seeks the first image from `number` on that is no smaller copy and no mask of another one. Returns its number, or -1
 * if there is none, or if it cannot be read: see rejection(). */
inline int seekPicture(MapImage& file, int number) {
  for (; file.seek_subimage(number, 0); number++)
    if (!file.isCopyOrMask()) return number;
  return -1;
}

/* Number of a channel, given by its name or its number from 0; -1 if there is none. */
inline int channelNumber(const std::vector<std::string>& names, const std::string& channel) {
  const auto named = std::find(names.begin(), names.end(), channel);
  if (named != names.end()) return int(named - names.begin());
  int number = -1;
  const char* const end = channel.data() + channel.size();
  const auto parsed = std::from_chars(channel.data(), end, number);
  return parsed.ec == std::errc() && parsed.ptr == end && number >= 0 && number < int(names.size()) ? number : -1;
}

/* "R, G, B" */
inline std::string listOfChannels(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

} // namespace programs
