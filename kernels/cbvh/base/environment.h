// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The environment variable EMBREE_CBVH: a comma-separated list, for example "1,max_error=0.001,verbose". */

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

namespace embree
{
  /*! Returns the items that are not empty, without surrounding blanks. */
  inline std::vector<std::string> environmentItems ()
  {
    std::vector<std::string> all;
    const char* text = getenv("EMBREE_CBVH");
    if (text == nullptr) return all;
    std::stringstream items(text);
    std::string item;
    while (std::getline(items,item,','))
    {
      const size_t begin = item.find_first_not_of(" \t"), end = item.find_last_not_of(" \t");
      if (begin != std::string::npos) all.push_back(item.substr(begin,end-begin+1));
    }
    return all;
  }

  /*! True if commits must print a line even at verbosity 0. */
  inline bool environmentRequestsCommitLines ()
  {
    const std::vector<std::string> items = environmentItems();
    return std::find(items.begin(),items.end(),"verbose") != items.end();
  }
}
