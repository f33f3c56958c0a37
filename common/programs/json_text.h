// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace programs {

/* Replaces bytes that are not UTF-8, as file names may contain some. Ends with a line feed. */
inline std::string textOfJson(const nlohmann::json& json, int indentation) {
  return json.dump(indentation, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

} // namespace programs
