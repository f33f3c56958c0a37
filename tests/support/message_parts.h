// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace programs::test {

/* True if the message contains all parts in this order. Tests compare place and values; the wording may change. */
inline testing::AssertionResult containsInOrder(const std::string& message, const std::vector<std::string>& parts) {
  size_t at = 0;
  for (const std::string& part : parts) {
    const size_t found = message.find(part, at);
    if (found == std::string::npos)
      return testing::AssertionFailure() << "no '" << part << "' at or after character " << at << " of: " << message;
    at = found + part.size();
  }
  return testing::AssertionSuccess();
}

// Returns the first line that contains the part, or "".
inline std::string lineWith(const std::string& text, const std::string& part) {
  const size_t at = text.find(part);
  if (at == std::string::npos) return "";
  const size_t begin = at == 0 ? 0 : text.rfind('\n', at - 1) + 1; // npos + 1 is 0
  return text.substr(begin, text.find('\n', at) - begin);
}

} // namespace programs::test
