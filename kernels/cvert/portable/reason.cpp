// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "reason.h"

namespace cvert {
std::string Reason::message() const {
  std::string message;
  int next = 0;
  for (const char* c = text; *c; c++) {
    if (*c == '%' && next < 2) message += std::to_string(values[next++]);
    else message += *c;
  }
  return message;
}
} // namespace cvert
