// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks device strings such as "threads=4,isa=avx2", in which Embree ignores unknown keys. Does not include Embree, so
 * that libembree_cbvh can use it. */

#include <string>
#include <vector>

namespace embree
{
  /*! True if Embree or its compression knows a key. */
  bool isDeviceKey (const std::string& key);

  /*! Returns the known key that is most similar to a word. */
  std::string nearestDeviceKey (const std::string& word);

  /*! Returns the first of `words` that begins with `word`, otherwise the most similar one. */
  std::string nearestWord (const std::string& word, const std::vector<std::string>& words);

  /*! Checks all keys of a device string, and the values whose errors Embree ignores. Returns an empty string, or a
   *  message with the first invalid key or value and what is accepted. */
  std::string findDeviceStringError (const char* deviceString);

  /*! Returns and clears the message of this thread's last rejected setting. Empty if there is none. */
  std::string takeSettingError ();
  void keepSettingError (const std::string& message);
}
