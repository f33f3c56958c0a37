// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks device strings such as "threads=4,isa=avx2", whose unknown keys Embree ignores. Independent of Embree, so that
 * libembree_cbvh can use it. */

#include <string>
#include <vector>

namespace embree
{
  /*! True if Embree or its compression knows a key. */
  bool isDeviceKey (const std::string& key);

  /*! Returns the most similar known key. */
  std::string nearestDeviceKey (const std::string& word);

  /*! Returns the first word that begins with `word`, otherwise the most similar one. */
  std::string nearestWord (const std::string& word, const std::vector<std::string>& words);

  /*! Checks all keys, and values whose errors Embree ignores. Returns an empty string, or a message with the first
   *  invalid key or value and what is accepted. */
  std::string findDeviceStringError (const char* deviceString);

  /*! Returns and clears the message of this thread's last rejected setting, or an empty string. */
  std::string takeSettingError ();
  void keepSettingError (const std::string& message);
}
