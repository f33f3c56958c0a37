// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the programs' option parsers share. */

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
#include <optional>
#include <string>
#include <system_error>
#include <vector>

namespace cbvh {

/* The option of a program that is most like a word with two hyphens. */
inline std::string nearestOption(const CLI::App& app, const std::string& word)
{
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return nearestWord(word, names);
}

/* False after --help and --version, which have been printed then. Throws Error for what CLI11 refuses. */
inline bool parseCommandLine(CLI::App& app, int argc, char** argv)
{
  app.set_version_flag("--version", RTC_COMPRESSION_VERSION_STRING, "print our version, and the library in use, and exit");
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::CallForVersion&)
  {
    writeStandardOutput(app.get_name() + " " + RTC_COMPRESSION_VERSION_STRING + "\nlibrary: " + loadedLibrary().description() + "\n");
    return false;
  }
  catch (const CLI::CallForHelp&)
  {
    writeStandardOutput(app.help());
    return false;
  }
  catch (const CLI::ArgumentMismatch& e)
  {
    /* "--level: At Most 1 required but received 2" */
    const std::string text = e.what(), mark = ": At Most 1 required but received ";
    const size_t at = text.find(mark);
    throw Error(at == std::string::npos ? text : text.substr(0, at) + " is given " + text.substr(at + mark.size()) + " times");
  }
  catch (const CLI::ExtrasError& e)
  {
    for (const std::string& word : app.remaining())
      if (word.compare(0, 2, "--") == 0)
        throw Error("unknown option " + word.substr(0, word.find('=')) + ", did you mean " + nearestOption(app, word.substr(0, word.find('='))) + "? --help lists all options");
    throw Error(e.what());
  }
  catch (const CLI::ParseError& e)
  {
    throw Error(e.what());
  }
  return true;
}

/* What traces, see validateTraceDevice. */
inline void addDeviceOption(CLI::App& app, std::string& device)
{
  app.add_option("--device", device, "what traces: cpu, vulkan, or ray-query for a driver's; the last two alone or with : and an index or a part of a name")
    ->type_name("DEVICE")->capture_default_str();
}

/* Throws Error that names the option, also for a value that is not finite. */
inline void requireNotNegative(const std::string& option, float value)
{
  if (!(value >= 0.0f) || !std::isfinite(value))
    throw Error(option + " must be finite and not negative");
}

/* --level as a word, "auto" or a number. */
struct LevelWords
{
  std::string level = "auto", frameLevel = "auto";
  float quadSize = 1;
  std::optional<float> maxPixelError; // none: not said
};

/* Of --level auto, where none is given. A quarter of a pixel moves nothing that one sees move, but quads are as small, and so their normals turn: smooth
 * surfaces get rings and grain. With 1/32 these are gone, for a tenth more memory. */
constexpr float autoPixelError = 1.0f / 32.0f;
constexpr int fixedLevel = 6;           // where representations are compared and no level is given

/* --level with auto, --frame-level, --quad-size and --max-pixel-error. */
inline void addViewLevelOptions(CLI::App& app, LevelWords& words)
{
  app.add_option("--level", words.level, "tessellation level, " + levelRange() + ": 2^L x 2^L quads a face; auto: edges get as many as the view needs, at most 4096, and above 64 as the map has texels")
    ->type_name("L|auto")->capture_default_str();
  app.add_option("--quad-size", words.quadSize, "length of quads' edges with --level auto, in pixels, about")->type_name("P")->capture_default_str();
  app.add_option("--frame-level", words.frameLevel, "frame level, at which local frames start: " + levelRange() + ", or auto")
    ->type_name("N")->capture_default_str();
  app.add_option("--max-pixel-error", words.maxPixelError,
                 "spacing of cVERT's vertices in pixels of the view, at most; 0 for 1/36 of a quad's edge [" + shortNumber(autoPixelError) + " with --level auto, else 0]")
    ->type_name("P");
}

/* Reads it. Returns whether the level is auto; else sets it. Throws Error that names the option. */
inline bool readLevel(const LevelWords& words, int& level)
{
  if (!(words.quadSize > 0.0f) || !std::isfinite(words.quadSize))
    throw Error("--quad-size must be finite and more than 0");
  if (words.maxPixelError)
    requireNotNegative("--max-pixel-error", *words.maxPixelError);
  if (words.level == "auto")
    return true;
  const char* const end = words.level.data() + words.level.size();
  const auto [next, code] = std::from_chars(words.level.data(), end, level);
  if (code != std::errc() || next != end)
    throw Error("--level '" + words.level + "' is neither auto nor a number, " + levelRange());
  return false;
}

/* --level and --frame-level. */
inline void addLevelOptions(CLI::App& app, int& level, std::string& frameLevel)
{
  app.add_option("--level", level, "tessellation level, " + levelRange() + ": 2^L x 2^L quads a face")
    ->type_name("L")->capture_default_str();
  app.add_option("--frame-level", frameLevel, "frame level, at which local frames start: " + levelRange() + ", or auto")
    ->type_name("N")->capture_default_str();
}

/* Values of --representation and --frame-level. Throws Error that names the options, or, before any work is
 * done, the library that is loaded where it cannot compress. */
inline std::vector<Representation> parseRepresentationOptions(const std::string& list, const std::string& frameLevel)
{
  std::vector<Representation> representations;
  try
  {
    representations = parseRepresentations(list, parseFrameLevel(frameLevel));
  }
  catch (const Error& e)
  {
    throw Error(std::string("--representation or --frame-level: ") + e.what());
  }
  for (const Representation& representation : representations)
    if (representation.isCompressed())
      requireCompression();
  return representations;
}

} // namespace cbvh
