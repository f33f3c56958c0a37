// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"

#include "device_string.h"
#include "environment.h"
#include "lower_case.h"

#include <cctype>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <locale>
#include <mutex>
#include <new>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace interposer {

bool Options::compresses(RTCGeometryType type) const {
  switch (type) {
  case RTC_GEOMETRY_TYPE_SUBDIVISION: return true;
  case RTC_GEOMETRY_TYPE_GRID: return compressesGrids;
  case RTC_GEOMETRY_TYPE_QUAD: return compressesQuads;
  case RTC_GEOMETRY_TYPE_TRIANGLE: return compressesTriangles;
  default: return false;
  }
}

static bool parseDistance(const std::string& text, float& distance) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  float value = -1;
  if (!(stream >> value) || !stream.eof() || !std::isfinite(value) || value < 0) return false;
  distance = value;
  return true;
}

static bool parseSwitch(const std::string& text, bool& value) {
  value = text == "1";
  return text == "0" || text == "1";
}

/* True for one of the names of representations, with the prefix "c" or "cbvh." or without. */
static bool isAnyOf(const std::set<std::string>& names, const std::string& item) {
  const std::string name = embree::lowerCase(item);
  for (const char* prefix : {"cbvh.", "c", ""}) {
    const size_t length = std::strlen(prefix);
    if (name.compare(0, length, prefix) == 0 && names.count(name.substr(length)) != 0) return true;
  }
  return false;
}

/* True for names of representations, and their settings, that only libembree3 of this project supports. */
static bool isOtherRepresentation(const std::string& item) {
  if (isAnyOf({"grid", "voxel", "leaf"}, item)) return true;
  const std::string key = item.substr(0, item.find('='));
  return key != item && (key == "frame_level" || key == "level" || key == "fallback_faces" || key == "exact_faces");
}

/* Applies an item of EMBREE_CBVH. Returns false if it is unknown or has an invalid value. The last of several items
 * that turn compression on or off decides. */
static bool parse(const std::string& item, Options& options) {
  if (embree::parseVerbose(item, options.isVerbose)) return true; // libembree_cbvh reads it, too
  const size_t equals = item.find('=');
  if (equals == std::string::npos) {
    if (item == "release_input") return true; // libembree_cbvh always releases input
    if (item == "0" || item == "none") {
      options.isOn = false;
      return true;
    }
    if (item != "1" && !isAnyOf({"vert", "tile"}, item)) return false;
    return options.isOn = true; // libembree_cbvh reads which of them
  }
  const std::string key = item.substr(0, equals), value = item.substr(equals + 1);
  if (key == "max_error") return parseDistance(value, options.maxError);
  if (key == "grids") return parseSwitch(value, options.compressesGrids);
  if (key == "quads") return parseSwitch(value, options.compressesQuads);
  if (key == "triangles") return parseSwitch(value, options.compressesTriangles);
  if (key == "memory") return !value.empty(); // libembree_cbvh reads it
  return key == "release_input" && (value == "0" || value == "1");
}

const Options& options() {
  static const Options options = [] {
    Options read;
    bool isInvalid = false;
    for (const std::string& item : embree::environmentItems()) {
      if (parse(item, read)) continue;
      if (isOtherRepresentation(item)) {
        if (item.find('=') == std::string::npos) read.isOn = true; // a representation
        warnOnce("EMBREE_CBVH: \"%s\" is not supported: compressed geometry is stored as cTILE or cVERT", item.c_str());
        continue;
      }
      isInvalid = true; // libembree3 of this project rejects the item, too
      const std::vector<std::string> suggestions = {"max_error",     "grids",   "quads", "triangles", "memory",
                                                    "release_input", "verbose", "tile",  "vert"};
      const std::string key = item.substr(0, item.find('=')), nearest = embree::nearestName(key, suggestions);
      const std::string error = nearest == key ? "is not valid." : "is not known, did you mean " + nearest + "?";
      warnOnce("EMBREE_CBVH: \"%s\" %s Nothing is compressed. Accepted are "
               "max_error=<distance>, memory=<bytes>, grids=0|1, quads=0|1, triangles=0|1, release_input, verbose, "
               "verbose=<number>, tile, vert, 1, none and 0",
               item.c_str(), error.c_str());
    }
    read.isOn &= !isInvalid;
    if (read.isVerbose && !read.isOn && !isInvalid)
      warnOnce("EMBREE_CBVH: nothing is compressed: expected the item 1, without a later 0");
    return read;
  }();
  return options;
}

/* Prints the line unless one with the same key was printed before. */
static void printOnce(const char* line, const std::string& key) {
  /* Never destroyed, because programs release geometries in destructors of static objects. */
  static std::mutex& mutex = *new std::mutex;
  static std::set<std::string>& printed = *new std::set<std::string>;
  const std::lock_guard<std::mutex> lock(mutex);
  if (printed.insert(key).second) std::fprintf(stderr, "libembree_cbvh_interposer: %s\n", line);
}

void warnOnce(const char* format, ...) {
  char line[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line, sizeof(line), format, arguments);
  va_end(arguments);
  try {
    printOnce(line, line);
  } catch (const std::bad_alloc&) { std::fprintf(stderr, "libembree_cbvh_interposer: %s\n", line); }
}

void reportLeftToEmbree(const char* geometry, const char* reason) {
  if (!options().isVerbose) return;
  try {
    const std::string line = std::string(geometry) + " is left to Embree: " + reason;
    std::string withoutNumbers;
    for (const char c : line)
      if (!std::isdigit((unsigned char)c)) withoutNumbers += c;
    printOnce(line.c_str(), withoutNumbers);
  } catch (const std::bad_alloc&) {}
}

} // namespace interposer
