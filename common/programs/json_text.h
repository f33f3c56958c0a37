// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace cbvh {

/* Replaces bytes of names that are not UTF-8 by U+FFFD, because JSON requires UTF-8. */
inline std::string jsonText(const nlohmann::json& json, int indent)
{
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

} // namespace cbvh
