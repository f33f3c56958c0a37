// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "device_string.h"
#include "lower_case.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <locale>
#include <sstream>

namespace embree {
namespace {
/*! How values are checked. Name: whether an accelerator or builder of this name exists is checked when a scene is
 *  built. Any: values of cbvh keys are checked when they are parsed. */
enum class Value { Any, Name, Integer, Number, CacheSize, Isa, Frequency, Quality, SceneFlags };

struct Keys {
  Value value;
  const char* names; //!< separated by blanks
};

/*! Keys of State::parse in kernels/common/state.cpp, and of CompressionSettings::parse. cbvh_exact_faces is a former
 * name of cbvh_fallback_faces. */
const Keys keys[] = {
    {Value::Integer,
     "threads user_threads set_affinity affinity start_threads enable_selockmemoryprivilege hugepages "
     "float_exceptions object_accel_min_leaf_size object_accel_max_leaf_size object_accel_mb_min_leaf_size "
     "object_accel_mb_max_leaf_size instancing_open_min instancing_block_size instancing_open_max_depth "
     "instancing_open_max verbose benchmark presplits alloc_main_block_size alloc_num_main_slots "
     "alloc_thread_block_size alloc_single_thread_alloc"},
    {Value::Number, "instancing_open_factor max_spatial_split_replications"},
    {Value::CacheSize, "tessellation_cache_size cache_size"},
    {Value::Isa, "isa max_isa max_builder_isa"},
    {Value::Frequency, "frequency_level"},
    {Value::Quality, "quality"},
    {Value::SceneFlags, "scene_flags"},
    {Value::Name, "accel builder traverser accel_mb builder_mb traverser_mb tri_accel tri_builder tri_traverser "
                  "tri_accel_mb tri_builder_mb tri_traverser_mb quad_accel quad_builder quad_traverser quad_accel_mb "
                  "quad_builder_mb quad_traverser_mb line_accel line_builder line_traverser line_accel_mb "
                  "line_builder_mb line_traverser_mb hair_accel hair_builder hair_traverser hair_accel_mb "
                  "hair_builder_mb hair_traverser_mb object_accel object_builder object_accel_mb object_builder_mb "
                  "subdiv_accel subdiv_accel_mb grid_accel grid_accel_mb"},
    {Value::Any, "cbvh_frame_level cbvh_max_error cbvh_fallback_faces cbvh_exact_faces cbvh_grids cbvh_quads "
                 "cbvh_triangles cbvh_memory cbvh_release_input"},
};

struct Key {
  std::string name;
  Value value;
};

const std::vector<Key>& allKeys() {
  static const std::vector<Key> all = [] {
    std::vector<Key> list;
    for (const Keys& k : keys) {
      std::istringstream names(k.names);
      for (std::string name; names >> name;) list.push_back({name, k.value});
    }
    return list;
  }();
  return all;
}

const Key* find(const std::string& name) {
  const std::vector<Key>& all = allKeys();
  const auto key = std::find_if(all.begin(), all.end(), [&](const Key& k) { return name == k.name; });
  return key == all.end() ? nullptr : &*key;
}

/*! Levenshtein distance. */
size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); j++) row[j] = j;
  for (size_t i = 0; i < a.size(); i++) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); j++) {
      const size_t replaced = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min(replaced, std::min(row[j], row[j + 1]) + 1);
    }
  }
  return row[b.size()];
}

/*! Accepted values; empty if there is no list. */
std::vector<std::string> acceptedValues(Value value) {
  switch (value) {
  case Value::Isa:
    return {
        "sse",  "sse2", "sse3", "ssse3", "sse41", "sse4.1", "sse42", "sse4.2", "avx", "avxi", "avx2", "avx512",
#if defined(__aarch64__)
        "neon", // Embree treats unknown values as sse2, which selects NEON
#endif
    };
  case Value::Frequency: return {"simd128", "simd256", "simd512"};
  case Value::Quality: return {"low", "medium", "high"};
  case Value::SceneFlags: return {"dynamic", "compact", "robust"};
  default: return {};
  }
}

/*! T: float or int. Rejects numbers above `highest` or out of its range and, for int, fractions. */
template<typename T>
bool isNumber(const std::string& text, T highest = std::numeric_limits<T>::max()) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  T number;
  return (stream >> number) && stream.eof() && number <= highest;
}

/*! True for an identifier of Embree's lexer. */
bool isName(const std::string& text) {
  const std::string letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
  return letters.find(text[0]) != std::string::npos &&
         text.find_first_not_of(letters + "0123456789.") == std::string::npos;
}

std::string findValueError(const Key& key, std::string value) {
  const std::string prefix = "invalid value \"" + value + "\" of " + key.name + ": ";
  if (value.empty()) return prefix + "expected " + key.name + "=<value>";
  if (key.value == Value::Number)
    return isNumber<float>(value) && value[0] != '-' ? "" : prefix + "expected a number, 0 or more";
  if (key.value == Value::CacheSize) // Embree converts it to bytes in 64 bits
    return isNumber<float>(value, 1e13f) && value[0] != '-' ? "" : prefix + "expected a number from 0 to 1e13";
  if (key.value == Value::Integer) return isNumber<int>(value) ? "" : prefix + "expected an integer of 32 bits";
  if (key.value == Value::Name) return isName(value) ? "" : prefix + "expected a name";
  const std::vector<std::string> accepted = acceptedValues(key.value);
  if (accepted.empty()) return "";
  if (key.value == Value::Isa) value = lowerCase(value); // Embree ignores case, too
  for (size_t at = 0; at <= value.size();) {
    const size_t end = key.value == Value::SceneFlags ? std::min(value.find('|', at), value.size()) : value.size();
    const std::string item = value.substr(at, end - at);
    at = end + 1;
    if (std::find(accepted.begin(), accepted.end(), item) != accepted.end()) continue;
    std::string all;
    for (const std::string& a : accepted) all += (all.empty() ? "" : ", ") + a;
    return prefix + "did you mean " + nearestName(item, accepted) + "? Expected one of " + all;
  }
  return "";
}
} // namespace

std::string nearestName(const std::string& name, const std::vector<std::string>& names) {
  for (const std::string& candidate : names)
    if (!name.empty() && candidate.compare(0, name.size(), name) == 0) return candidate;
  return *std::min_element(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
    return editDistance(name, a) < editDistance(name, b);
  });
}

bool isDeviceKey(const std::string& key) { return find(key) != nullptr; }

std::string nearestDeviceKey(const std::string& name) {
  if (isDeviceKey("cbvh_" + name)) return "cbvh_" + name; // EMBREE_CBVH has the key without the prefix
  std::vector<std::string> names;
  for (const Key& key : allKeys()) names.push_back(key.name);
  return nearestName(name, names);
}

std::string findDeviceStringError(const char* deviceString) {
  const std::string text = deviceString ? deviceString : "";
  const char* const blanks = " \t\r\n";
  for (size_t at = text.find_first_not_of(" \t\r\n,"); at != std::string::npos;
       at = text.find_first_not_of(" \t\r\n,", at)) {
    const size_t end = std::min(text.find_first_of(" \t\r\n,=", at), text.size());
    const std::string name = text.substr(at, end - at);
    const Key* const key = find(name);
    if (!key) return "unknown key \"" + name + "\": did you mean " + nearestDeviceKey(name) + "?";
    at = std::min(text.find_first_not_of(blanks, end), text.size());
    std::string value;
    if (at < text.size() && text[at] == '=') {
      /* Like Embree's lexer: a value ends at a comma or blank, except for blanks around the | of scene_flags. */
      for (at++; at < text.size() && text[at] != ','; at++) {
        if (!std::strchr(blanks, text[at])) {
          value += text[at];
          continue;
        }
        const size_t next = text.find_first_not_of(blanks, at);
        if (next == std::string::npos) {
          at = text.size();
          break;
        }
        if (!value.empty() && value.back() != '|' && text[next] != '|') break;
        at = next - 1;
      }
    }
    const std::string valueError = findValueError(*key, value);
    if (!valueError.empty()) return valueError;
  }
  return "";
}
} // namespace embree
