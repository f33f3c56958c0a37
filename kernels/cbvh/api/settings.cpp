// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Parses the compression settings of the device string and of EMBREE_CBVH (settings/settings.h). */

#include "../embree/scene.h"
#include "../operations/device_string.h"
#include "../operations/lower_case.h"
#include "factory.h"
#include "../settings/memory_budget.h"
#include "../settings/settings.h"
#include "../base/environment.h"
#include "../base/kinds.h"
#include "../base/number_text.h"
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iostream>
#include <locale>
#include <sstream>
#include <cmath>

namespace embree {
/*! Throws after printing the message, because no device exists yet to report it. */
static void throwInvalid(const std::string& name, const std::string& value, const std::string& expected) {
  const std::string message = "invalid value \"" + value + "\" of " + name + ": " + expected;
  std::cerr << "Embree: Invalid argument, (" << message << ")" << std::endl;
  throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, message);
}

/*! For example "cvert", "vert" or "cbvh.vert"; case-insensitive. */
static bool parseKind(const std::string& name, RTCCompression& compression) {
  const std::string lower = lowerCase(name);
  for (const cbvh::KindDescription& kind : cbvh::kindDescriptions)
    for (const char* prefix : {"c", "", "cbvh."})
      if (lower == std::string(prefix) + kind.key) {
        compression = kind.compression();
        return true;
      }
  return false;
}

/*! Returns false also for Embree's own values, such as "grid". */
static bool selectsCompression(const std::string& name, RTCCompression& compression) {
  const std::string lower = lowerCase(name);
  if (lower == "cbvh") {
    compression = CompressionSettings::preferredCompression;
    return true;
  }
  return lower != "grid" && parseKind(lower, compression); // "grid" is Embree's GRID
}

bool isCompressedSubdivAccel(const std::string& subdivAccel) {
  RTCCompression compression;
  return selectsCompression(subdivAccel, compression);
}

/*! Keys of EMBREE_CBVH with a value; parseEnvironment() reads others too. In a device string they begin with
 *  "cbvh_". */
static const char* const keys[] = {"frame_level", "max_error", "fallback_faces", "grids",      "quads",
                                   "triangles",   "memory",    "release_input",  "exact_faces"}; // former name of
                                                                                                 // fallback_faces

static bool isKey(const std::string& name) {
  return std::find(std::begin(keys), std::end(keys), name) != std::end(keys);
}

/*! Unknown keys of the device string, and their values. A new device calls parseEnvironment(), which clears them,
 *  then parse(), which collects them, and finishParsing(), which may reject them. */
static thread_local std::vector<std::pair<std::string, std::string>> unknownKeys;

/*! For an empty prefix, returns "grid, voxel, leaf, vert or tile". */
static std::string kindKeys(const std::string& prefix) {
  std::string list;
  for (uint32_t k = 0; k < cbvh::numKinds; k++)
    list += (k == 0 ? "" : k + 1 < cbvh::numKinds ? ", " : " or ") + prefix + cbvh::kindDescriptions[k].key;
  return list;
}

/*! item: the unknown key, or key=value. where: "EMBREE_CBVH" or the like. prefix: with which keys there begin. */
static void throwUnknownKey(const std::string& where, const std::string& item, const std::string& prefix) {
  const std::string key = item.substr(0, item.find('='));
  const bool hasPrefix = key.compare(0, prefix.size(), prefix) == 0;
  const std::string name = hasPrefix ? key.substr(prefix.size()) : key;
  throwInvalid(where, item,
               "unknown key, did you mean " + prefix + nearestName(name, {std::begin(keys), std::end(keys)}) + "?");
}

void CompressionSettings::setFrameLevel(const std::string& name, const std::string& value) {
  if (value == "auto") {
    frameLevel = RTC_COMPRESSION_FRAME_LEVEL_AUTO;
    return;
  }
  char* end = nullptr;
  const long n = strtol(value.c_str(), &end, 10);
  if (value.empty() || *end != 0 || n < 0 || n > long(cbvh::maxFramedLevel))
    throwInvalid(name, value, "expected 0 to " + std::to_string(cbvh::maxFramedLevel) + " or auto");
  frameLevel = int(n);
}

void CompressionSettings::setMaxError(const std::string& name, const std::string& value) {
  /* the classic locale: the decimal point is '.', whatever the process's locale */
  std::istringstream stream(value);
  stream.imbue(std::locale::classic());
  float e = -1.0f;
  if (!(stream >> e) || !stream.eof() || !std::isfinite(e) || e < 0.0f)
    throwInvalid(name, value, "expected a distance, 0 or more");
  maxError = e;
}

/*! For example "512M", "1.5G" or "1000000": bytes, or units of 2^10, 2^20 or 2^30. */
void CompressionSettings::setMemory(const std::string& name, const std::string& value) {
  std::istringstream stream(value);
  stream.imbue(std::locale::classic());
  double number = -1;
  std::string unit;
  if (stream >> number) stream >> unit;
  const size_t power = unit.empty() ? 0 : std::string(" kmg").find(lowerCase(unit));
  const double bytes = power < 4 ? std::ldexp(number, int(10 * power)) : 0;
  if (!(bytes >= 1) || bytes > 0x1p62)
    throwInvalid(name, value, "expected bytes, or a number with K, M or G, for example 512M");
  memory = std::make_shared<cbvh::MemoryBudget>(size_t(bytes));
}

static bool parseSwitch(const std::string& name, const std::string& value) {
  if (value != "0" && value != "1") throwInvalid(name, value, "expected 0 or 1");
  return value == "1";
}

/*! key: one of `keys`. name: what messages call it. */
void CompressionSettings::set(const std::string& name, const std::string& key, const std::string& value) {
  if (key == "frame_level") setFrameLevel(name, value);
  else if (key == "max_error") setMaxError(name, value);
  else if (key == "fallback_faces" || key == "exact_faces") fallbackFaces = parseSwitch(name, value);
  else if (key == "grids") compressesGrids = parseSwitch(name, value);
  else if (key == "quads") compressesQuads = parseSwitch(name, value);
  else if (key == "triangles") compressesTriangles = parseSwitch(name, value);
  else if (key == "memory") setMemory(name, value);
  else releasesInput = parseSwitch(name, value);
}

/*! Returns an identifier or number of Embree's lexer as text, otherwise "". Each accessor throws for tokens of other
 *  types, but Float() accepts integers. */
static std::string valueText(const Token& token) {
  try {
    return token.Identifier();
  } catch (const std::exception&) {}
  try {
    return std::to_string(token.Int());
  } catch (const std::exception&) {}
  try {
    return numberText(token.Float());
  } catch (const std::exception&) {}
  return "";
}

/*! Reads and returns the next character if it is one of these, otherwise returns 0. */
static char readAnyOf(TokenStream& stream, const char* characters) {
  for (; *characters; characters++)
    if (stream.trySymbol(std::string(1, *characters))) return *characters;
  return 0;
}

/*! Reads the text of a value: up to a comma, or up to blanks before something else than a number. Embree's tokens
 *  do not contain the whole text: "0x10" becomes 0, "1 2" becomes 1, and 2^32+2 becomes 2. */
static std::string readValue(TokenStream& stream) {
  const char *const blanks = " \t\r\n", *const numberBegins = "0123456789+-.";
  std::string others; // all characters that neither separate settings nor begin numbers; 255 may be equal to EOF
  for (int c = 1; c < 255; c++)
    if (c != ',' && !std::strchr(blanks, c) && !std::strchr(numberBegins, c)) others += char(c);
  std::string value, before;
  for (;;) {
    char c = readAnyOf(stream, numberBegins);
    if (!c && before.empty()) c = readAnyOf(stream, others.c_str());
    if (c) {
      value += before + c;
      before.clear();
    } else if (const char blank = readAnyOf(stream, blanks)) {
      if (!value.empty()) before += blank;
    } else return value;
  }
}

bool CompressionSettings::parse(const Token& token, TokenStream& stream) {
  std::string key;
  try {
    key = token.Identifier();
  } catch (const std::exception&) { return false; }
  if (key.compare(0, 4, "cbvh") != 0) {
    if (isDeviceKey(key)) return false; // Embree parses it
    unknownKeys.push_back({key, ""});
    if (stream.trySymbol("=")) unknownKeys.back().second = valueText(stream.get());
    return true;
  }
  std::string value;
  if (stream.trySymbol("=")) value = readValue(stream);
  const std::string prefix = "cbvh_";
  if (key.compare(0, prefix.size(), prefix) != 0 || !isKey(key.substr(prefix.size())))
    throwUnknownKey("the device string", key, prefix);
  set(key, key.substr(prefix.size()), value);
  return true;
}

void CompressionSettings::parseEnvironment() {
  unknownKeys.clear();
  for (const std::string& item : environmentItems()) {
    bool isVerbose;
    if (parseVerbose(item, isVerbose)) continue; // environmentRequestsCommitLines() reads it
    const size_t equals = item.find('=');
    const std::string key = item.substr(0, equals);
    const std::string value = equals == std::string::npos ? "" : item.substr(equals + 1);
    if (equals == std::string::npos) {
      if (key == "release_input") releasesInput = true;
      else if (key == "none" || key == "0") compression = RTC_COMPRESSION_NONE;
      else if (key == "1") compression = preferredCompression;
      else if (isKey(key) || key == "level") throwInvalid("EMBREE_CBVH", item, "expected " + key + "=<value>");
      else if (!parseKind(key, compression))
        throwInvalid("EMBREE_CBVH", item, "expected 1, 0, none, verbose, release_input, " + kindKeys(""));
    } else if (key == "verbose") throwInvalid("EMBREE_CBVH verbose", value, "expected 0 or a positive integer");
    else if (key == "level") setFrameLevel("EMBREE_CBVH level", value);
    else if (isKey(key)) set("EMBREE_CBVH " + key, key, value);
    else throwUnknownKey("EMBREE_CBVH", item, "");
  }
}

static const char* nameOf(RTCCompression compression) {
  for (const cbvh::KindDescription& kind : cbvh::kindDescriptions)
    if (kind.compression() == compression) return kind.name;
  return "GRID, Embree's own";
}

void CompressionSettings::finishParsing(const std::string& subdivAccel, bool verbose) {
  RTCCompression ignored;
  if (!selectsCompression(subdivAccel, compression)) {
    if (lowerCase(subdivAccel).compare(0, 4, "cbvh") == 0)
      throwInvalid("subdiv_accel", subdivAccel, "expected cbvh, " + kindKeys("cbvh."));
    if (subdivAccel != "default") compression = RTC_COMPRESSION_NONE;
  }
  /* Embree ignores unknown keys. They are errors if subdiv_accel, or their value, requests compression. */
  for (const auto& entry : unknownKeys)
    if (selectsCompression(subdivAccel, ignored) || lowerCase(entry.second).compare(0, 4, "cbvh") == 0)
      throwInvalid("the device string", entry.first,
                   "unknown key, did you mean " + nearestDeviceKey(entry.first) + "?");

  if (verbose)
    std::cout << std::endl
              << "Embree CBVH " << RTC_COMPRESSION_VERSION_STRING << std::endl
              << "  Subdivision surfaces: " << nameOf(compression) << ", unless a geometry has another setting"
              << std::endl;
}

CompressionSettings CompressionSettings::resolve(const CompressionSettings& device) const {
  CompressionSettings r = *this;
  if (r.compression == RTC_COMPRESSION_INHERIT) r.compression = device.compression;
  if (r.compression == RTC_COMPRESSION_INHERIT) r.compression = RTC_COMPRESSION_NONE;
  if (r.frameLevel == RTC_COMPRESSION_FRAME_LEVEL_INHERIT) r.frameLevel = device.frameLevel;
  if (r.frameLevel == RTC_COMPRESSION_FRAME_LEVEL_INHERIT) r.frameLevel = RTC_COMPRESSION_FRAME_LEVEL_AUTO;
  if (r.maxError < 0.0f) r.maxError = device.maxError;
  if (r.fallbackFaces < 0) r.fallbackFaces = device.fallbackFaces;
  if (r.fallbackFaces < 0) r.fallbackFaces = 1;
  r.releasesInput |= device.releasesInput;
  return r;
}
} // namespace embree
