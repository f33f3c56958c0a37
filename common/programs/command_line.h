// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/error.h"
#include "basics/file_output.h"
#include "basics/nearest_word.h"
#include "building/loaded_library.h"
#include "building/representation.h"
#include "programs/surface_options.h"

#include <CLI/CLI.hpp>
#include <embree3/rtcore_compression.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

namespace programs {

inline std::string nearestOption(const CLI::App& app, const std::string& word) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return nearestWord(word, names);
}

/* Returns false after --help and --version, once their output is printed. Throws Error. */
inline bool parseCommandLine(CLI::App& app, int argc, char** argv) {
  app.set_version_flag("--version", RTC_COMPRESSION_VERSION_STRING,
                       "print the version of this program and of the library in use, and exit");
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForVersion&) {
    writeStandardOutput(app.get_name() + " " + RTC_COMPRESSION_VERSION_STRING +
                        "\nlibrary: " + loadedLibrary().description() + "\n");
    return false;
  } catch (const CLI::CallForHelp&) {
    writeStandardOutput(app.help());
    return false;
  } catch (const CLI::ArgumentMismatch& e) {
    /* CLI11's text: "--level: At Most 1 required but received 2" */
    const std::string text = e.what(), mark = ": At Most 1 required but received ";
    const size_t at = text.find(mark);
    if (at == std::string::npos) throw Error(text);
    throw Error(text.substr(0, at) + " is given " + text.substr(at + mark.size()) + " times: expected once");
  } catch (const CLI::ConversionError& e) {
    /* CLI11's text: "Could not convert: --cell = x" */
    const std::string text = e.what(), mark = "Could not convert: ", equals = " = ";
    const size_t at = text.find(equals);
    if (text.compare(0, mark.size(), mark) != 0 || at == std::string::npos) throw Error(text);
    const std::string name = text.substr(mark.size(), at - mark.size());
    const CLI::Option* const option = app.get_option_no_throw(name);
    const bool isFlag = option && option->get_items_expected_max() == 0;
    throw Error("invalid " + name + " '" + text.substr(at + equals.size()) + "': expected " +
                (isFlag ? "no value" : "a number as in --help"));
  } catch (const CLI::ExtrasError& e) {
    for (const std::string& word : app.remaining())
      if (word.compare(0, 2, "--") == 0) {
        const std::string option = word.substr(0, word.find('='));
        throw Error("unknown option " + option + ", did you mean " + nearestOption(app, option) +
                    "? --help lists all options");
      }
    throw Error(e.what());
  } catch (const CLI::ParseError& e) { throw Error(e.what()); }
  return true;
}

/* `more` describes further values of the program, and ends with "; ". */
inline void addDeviceOption(CLI::App& app, std::string& device, const std::string& more = "") {
  app.add_option("--device", device,
                 "device that traces: " + more +
                     "cpu, vulkan, or ray-query for the ray queries of a Vulkan driver; "
                     "append :N or :NAME to choose a Vulkan device by its index or a part of its name")
      ->type_name("DEVICE")
      ->capture_default_str();
}

inline void addIsaOption(CLI::App& app, std::string& isa) {
  app.add_option("--isa", isa, "widest instruction set to use: sse2, sse4.2, avx, avx2 or avx512 [the host's best]")
      ->type_name("ISA");
}

/* For options of unsigned numbers: without it, CLI11 reads -1 as the largest number. */
inline CLI::Range countRange(int64_t least = 0) { return CLI::Range(least, int64_t(UINT32_MAX)); }

inline void requireNotNegative(const std::string& option, float value) {
  if (!(value >= 0.0f) || !std::isfinite(value))
    throw Error("invalid " + option + " " + shortNumber(value) + ": expected a finite number of at least 0");
}

struct LevelOptions {
  std::string level = "auto", frameLevel = "auto";
  float quadSize = 1;
  std::optional<float> maxPixelError;
};

/* Default of --max-pixel-error with --level auto. Larger errors turn the normals of pixel-sized quads, so that
 * smooth surfaces show rings and grain; 1/32 avoids this for a tenth more memory. */
constexpr float autoPixelError = 1.0f / 32.0f;

inline void addViewLevelOptions(CLI::App& app, LevelOptions& options) {
  app.add_option("--level", options.level,
                 "tessellation level, " + levelRange() +
                     ": each face has 2^L x 2^L quads; auto: edges get as many "
                     "quads as the view needs, at most 4096, and above 64 at most one per texel of the map")
      ->type_name("L|auto")
      ->capture_default_str();
  app.add_option("--quad-size", options.quadSize, "approximate length of quads' edges with --level auto, in pixels")
      ->type_name("P")
      ->capture_default_str();
  app.add_option("--frame-level", options.frameLevel,
                 "frame level, at which local frames start: " + levelRange() + ", or auto")
      ->type_name("N")
      ->capture_default_str();
  app.add_option("--max-pixel-error", options.maxPixelError,
                 "largest spacing of cVERT's vertices, in pixels of the view; 0 for 1/36 of a quad's edge [" +
                     shortNumber(autoPixelError) + " with --level auto, else 0]")
      ->type_name("P");
}

/* Returns true if the level is auto; otherwise sets `level`. Throws Error with the option. */
inline bool parseLevel(const LevelOptions& options, int& level) {
  if (!(options.quadSize > 0.0f) || !std::isfinite(options.quadSize))
    throw Error("invalid --quad-size " + shortNumber(options.quadSize) + ": expected a finite number above 0");
  if (options.maxPixelError) requireNotNegative("--max-pixel-error", *options.maxPixelError);
  if (options.level == "auto") return true;
  const char* const end = options.level.data() + options.level.size();
  const auto [next, code] = std::from_chars(options.level.data(), end, level);
  if (code != std::errc() || next != end)
    throw Error("invalid --level '" + options.level + "': expected " + levelRange() + " or auto");
  return false;
}

/* Throws Error with the options, or with the loaded library if it cannot compress. */
inline std::vector<Representation> parseRepresentationOptions(const std::string& list, const std::string& frameLevel) {
  std::vector<Representation> representations;
  try {
    representations = parseRepresentations(list, parseFrameLevel(frameLevel));
  } catch (const Error& e) { throw Error(std::string("--representation or --frame-level: ") + e.what()); }
  for (const Representation& representation : representations)
    if (representation.isCompressed()) requireCompression();
  return representations;
}

} // namespace programs
