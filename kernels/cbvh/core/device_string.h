// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The keys of device strings, "threads=4,isa=avx2". Embree ignores keys that it does not know; the functions here find them.
 * Includes nothing of Embree, so that libembree_cbvh can use it. */

#include <string>
#include <vector>

namespace embree
{
  /*! True if Embree, or its compression, knows the key of a device string. */
  bool isDeviceKey (const std::string& key);

  /*! The key of a device string that is most like a word. */
  std::string nearestDeviceKey (const std::string& word);

  /*! The word of a list that a word begins, or that is most like it. */
  std::string nearestWord (const std::string& word, const std::vector<std::string>& words);

  /*! Checks all keys of a device string, and the values whose errors Embree ignores. Returns an empty string, or a message that names
   *  the first key or value that is wrong and what is accepted. */
  std::string whatIsWrongWith (const char* deviceString);

  /*! The message of the last setting that this thread was refused, or an empty string; forgets it. */
  std::string takeSettingError ();
  void keepSettingError (const std::string& message);
}
