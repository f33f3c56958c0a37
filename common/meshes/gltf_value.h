// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Values of a glTF document with their place, for errors such as "car.gltf: accessors[3].count is missing". */

#include "basics/error.h"
#include "basics/text.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace programs {

class GltfValue {
public:
  /* The document must outlive the value. `place` is empty for the document itself. */
  GltfValue(const nlohmann::json& json, const std::string& file, const std::string& place = "")
    : json(&json),
      file(file),
      place(place) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(file + ": " + printable((place.empty() ? "" : place + " ") + what));
  }

  bool has(const char* key) const { return json->is_object() && json->contains(key); }

  GltfValue member(const char* key) const {
    if (!has(key)) fail(std::string("has no '") + key + "'");
    return GltfValue((*json)[key], file, place.empty() ? key : place + "." + key);
  }

  /* Number of elements; 0 for a member that is missing. */
  size_t count(const char* key) const { return has(key) ? member(key).elements() : 0; }

  size_t elements() const {
    if (!json->is_array()) fail("is no array");
    return json->size();
  }

  GltfValue element(size_t i) const {
    if (i >= elements()) fail("has no element " + std::to_string(i) + ": it has " + std::to_string(elements()));
    return GltfValue((*json)[i], file, place + "[" + std::to_string(i) + "]");
  }

  /* Element of an array of the document that an index refers to. */
  GltfValue element(const char* array, size_t i) const { return member(array).element(i); }

  uint64_t integer() const {
    if (json->is_number_unsigned()) return json->get<uint64_t>();
    const double value = json->is_number_float() ? json->get<double>() : -1; // some programs write 3.0
    if (!(value >= 0 && value < 9e15 && value == std::floor(value))) fail("is no integer of 0 or more");
    return uint64_t(value);
  }

  uint64_t integer(const char* key) const { return member(key).integer(); }
  uint64_t integer(const char* key, uint64_t missing) const { return has(key) ? integer(key) : missing; }

  std::optional<size_t> index(const char* key) const {
    if (!has(key)) return {};
    return size_t(integer(key));
  }

  double number() const {
    if (!json->is_number()) fail("is no number");
    return json->get<double>();
  }

  std::vector<double> numbers() const {
    std::vector<double> values(elements());
    for (size_t i = 0; i < values.size(); i++) values[i] = element(i).number();
    return values;
  }

  std::string text() const {
    if (!json->is_string()) fail("is no string");
    return json->get<std::string>();
  }

  bool flag(const char* key) const {
    if (!has(key)) return false;
    if (!(*json)[key].is_boolean()) member(key).fail("is neither true nor false");
    return (*json)[key].get<bool>();
  }

  bool hasExtension(const char* name) const { return has("extensions") && member("extensions").has(name); }

private:
  const nlohmann::json* json;
  std::string file, place;
};

} // namespace programs
