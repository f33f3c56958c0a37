// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The environment variable EMBREE_CBVH: a comma-separated list, for example "1,max_error=0.001,verbose".
 * Independent of Embree, because the interposer compiles it, too. */

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

namespace embree {
/*! Returns the items that are not empty, without surrounding blanks. */
inline std::vector<std::string> environmentItems() {
  std::vector<std::string> all;
  const char* text = getenv("EMBREE_CBVH");
  if (text == nullptr) return all;
  std::stringstream items(text);
  std::string item;
  while (std::getline(items, item, ',')) {
    const size_t begin = item.find_first_not_of(" \t"), end = item.find_last_not_of(" \t");
    if (begin != std::string::npos) all.push_back(item.substr(begin, end - begin + 1));
  }
  return all;
}

/*! Parses "verbose", and "verbose=N" as in device strings, where 0 prints nothing. Returns false for other items, and
 *  then leaves isVerbose unchanged. */
inline bool parseVerbose(const std::string& item, bool& isVerbose) {
  if (item == "verbose") return isVerbose = true;
  const std::string prefix = "verbose=";
  if (item.compare(0, prefix.size(), prefix) != 0 || item.size() == prefix.size()) return false;
  if (item.find_first_not_of("0123456789", prefix.size()) != std::string::npos) return false;
  isVerbose = item.find_first_not_of('0', prefix.size()) != std::string::npos;
  return true;
}

/*! True if commits must print a line even at verbosity 0. The last of several items applies. */
inline bool environmentRequestsCommitLines() {
  bool isVerbose = false;
  for (const std::string& item : environmentItems()) parseVerbose(item, isVerbose);
  return isVerbose;
}
} // namespace embree
