// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Keys of device strings such as "threads=4,isa=avx2". Embree ignores unknown keys; the functions here detect them.
 * Does not include Embree, so that libembree_cbvh can use it. */

#include <string>
#include <vector>

namespace embree
{
  /*! True if Embree or its compression knows a key of a device string. */
  bool isDeviceKey (const std::string& key);

  /*! Returns the known key that is most similar to a word. */
  std::string nearestDeviceKey (const std::string& word);

  /*! Returns the first of `words` that begins with `word`, else the most similar one. */
  std::string nearestWord (const std::string& word, const std::vector<std::string>& words);

  /*! Checks all keys of a device string, and the values whose errors Embree ignores. Returns an empty string, or a
   *  message with the first invalid key or value and the accepted ones. */
  std::string whatIsWrongWith (const char* deviceString);

  /*! Returns and clears the message of the last setting of this thread that was rejected. Empty if there is none. */
  std::string takeSettingError ();
  void keepSettingError (const std::string& message);
}
