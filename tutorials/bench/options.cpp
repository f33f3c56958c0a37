// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"
#include "json.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "programs/command_line.h"
#include "programs/opened_files.h"
#include "programs/outputs.h"
#include "programs/view_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <system_error>

namespace programs {
namespace {

std::vector<std::string> split(const std::string& option, const std::string& list) {
  std::vector<std::string> entries;
  for (size_t begin = 0; begin <= list.size();) {
    const size_t end = std::min(list.find(',', begin), list.size());
    entries.push_back(list.substr(begin, end - begin));
    begin = end + 1;
    if (entries.back().empty())
      throw Error(option + " '" + list + "' has an empty entry: expected a comma-separated list");
    if (std::count(entries.begin(), entries.end(), entries.back()) > 1)
      throw Error(option + " '" + list + "' contains '" + entries.back() + "' twice: expected each entry once");
  }
  return entries;
}

/* Different numbers from 0 to `maximum`. */
std::vector<int> parseIntegers(const std::string& option, const std::string& list, int maximum) {
  std::vector<int> numbers;
  for (const std::string& entry : split(option, list)) {
    int value = 0;
    const char* const end = entry.data() + entry.size();
    const auto result = std::from_chars(entry.data(), end, value);
    if (result.ec != std::errc() || result.ptr != end || value < 0 || value > maximum)
      throw Error("invalid " + option + " '" + entry + "': expected a number from 0 to " + std::to_string(maximum));
    if (std::count(numbers.begin(), numbers.end(), value))
      throw Error(option + " '" + list + "' contains " + std::to_string(value) + " twice: expected each number once");
    numbers.push_back(value);
  }
  return numbers;
}

BenchScene parseScene(const std::string& entry, const SceneSettings& settings) {
  BenchScene scene{entry, settings};
  scene.label += settings.rough ? "-rough" : "";
  scene.label += settings.mapping.empty() ? "" : "-" + settings.mapping;
  scene.label += settings.count ? "-" + std::to_string(*settings.count) : "";
  scene.label += settings.motion.empty() ? "" : "-" + settings.motion;
  const size_t mark = entry.find(':');
  scene.settings.scene = entry.substr(0, mark);
  if (mark != std::string::npos) {
    float amplitude = 0;
    const char* const end = entry.data() + entry.size();
    const auto result = std::from_chars(entry.data() + mark + 1, end, amplitude);
    if (result.ec != std::errc() || result.ptr != end || !std::isfinite(amplitude))
      throw Error("invalid --scene '" + entry + "': expected a number as the amplitude after the colon");
    scene.settings.amplitude = amplitude;
  }
  validateScene(scene.settings);
  return scene;
}

/* "full,close" are two views; "ex,ey,ez,lx,ly,lz,fov" is one. */
std::vector<std::string> parseViews(const std::vector<std::string>& given, ImageSize size) {
  std::vector<std::string> views;
  for (const std::string& text : given) {
    if (std::count(text.begin(), text.end(), ',') == 6) {
      parseView(text, {0, 1, 0}, size);
      views.push_back(text);
      continue;
    }
    for (const std::string& entry : split("--view", text)) {
      if (entry != "full" && entry != "close") parseView(entry, {0, 1, 0}, size);
      views.push_back(entry);
    }
  }
  return views;
}

std::vector<Representation> parseAll(const std::string& names, const std::string& frameLevels) {
  std::vector<Representation> all;
  try {
    for (const std::string& level : split("--frame-level", frameLevels))
      for (const Representation& r : parseRepresentations(names, parseFrameLevel(level))) {
        const auto same = [&](const Representation& other) { return other.label() == r.label(); };
        if (std::none_of(all.begin(), all.end(), same)) all.push_back(r);
      }
  } catch (const Error& e) { throw Error(std::string("--representation or --frame-level: ") + e.what()); }
  return all;
}

/* For a POSIX shell. */
std::string quoted(const std::string& argument) {
  if (!argument.empty() && argument.find_first_of(" \t\n'\"\\$^*?;&|<>()[]{}`!#~") == std::string::npos)
    return argument;
  std::string inside;
  for (char c : argument) inside += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return "'" + inside + "'";
}

std::string commandLine(int argc, char** argv) {
  std::string command = std::filesystem::path(argv[0]).filename().string();
  for (int i = 1; i < argc; i++) command += " " + quoted(argv[i]);
  return command;
}

RaySet parseRaySet(const std::string& entry) {
  for (RaySet set : {Coherent, Incoherent})
    if (entry == raySetName(set)) return set;
  throw Error("unknown --ray-set '" + entry + "': expected coherent or incoherent");
}

/* Unparsed options, with the defaults that --help shows. */
struct OptionTexts {
  std::vector<std::string> files;
  SceneSettings settings;
  std::string scenes, libraries, levels = "6", representations = defaultRepresentations(), frameLevels = "auto";
  std::string isas = "best", device = "cpu", threads = "1", sets = "coherent,incoherent", queries = "closest";
  std::string modes = "single";
  std::string size = "768x768", pictureLevels, checks, position;
  std::vector<std::string> views;
  bool about = false;
};

/* In the order of --help. */

void declareLists(CLI::App& app, OptionTexts& texts) {
  addFileArguments(app, texts.files, false, false);
  app.add_option("--scene", texts.scenes,
                 "comma-separated list of " + listOfScenes() + "; an amplitude may follow after a colon")
      ->type_name("LIST");
  addSceneOptions(app, texts.settings);
  app.add_option("--view", texts.views, "full, close, or ex,ey,ez,lx,ly,lz,fov; may be repeated")
      ->type_name("LIST")
      ->default_str("full");
  app.add_option("--level", texts.levels, "tessellation levels, " + levelRange())
      ->type_name("LIST")
      ->capture_default_str();
  app.add_option("--representation", texts.representations,
                 "of " + listOfRepresentations(", ") + "; a frame level may follow after ^ or :")
      ->type_name("LIST")
      ->capture_default_str();
  app.add_option("--frame-level", texts.frameLevels,
                 "frame levels, at which local frames start: " + levelRange() + ", or auto")
      ->type_name("LIST")
      ->capture_default_str();
  app.add_option("--library", texts.libraries,
                 "builds of libembree3.so.3, or folders that contain one, instead of the program's own: speeds are\n"
                 "also relative to the first, and hits are compared with the hits of the first")
      ->type_name("LIST");
  app.add_option("--isa", texts.isas, "widest instruction sets: best, sse2, sse4.2, avx, avx2, avx512")
      ->type_name("LIST")
      ->capture_default_str();
  addDeviceOption(app, texts.device);
  app.add_option("--threads", texts.threads, "numbers of threads for tracing, 0 for all")
      ->type_name("LIST")
      ->capture_default_str();
  app.add_option("--ray-set", texts.sets, "ray sets: coherent, incoherent")->type_name("LIST")->capture_default_str();
  app.add_option("--query", texts.queries, "queries: closest, any")->type_name("LIST")->capture_default_str();
  app.add_option("--mode", texts.modes, "rays per call: single, packet4, packet8, packet16, stream")
      ->type_name("LIST")
      ->capture_default_str();
}

void declareMeasurement(CLI::App& app, BenchOptions& o, OptionTexts& texts) {
  app.add_option("--rays", o.rays, "rays per measurement, 0 for one per pixel")
      ->type_name("N")
      ->check(countRange())
      ->capture_default_str();
  app.add_option("--repeat", o.repeat, "measurements of each combination, 0 to skip speed")
      ->type_name("N")
      ->capture_default_str();
  app.add_option("--size", texts.size, "picture size")->type_name("WxH")->capture_default_str();
  app.add_option("--ray-offset", o.rayOffset,
                 "distance of bounced rays' origins from the surface, in diagonals of the bounding box")
      ->type_name("D")
      ->capture_default_str();
  app.add_option("--seed", o.seed, "seed of bounced rays, checks, and hits that are compared with the true surface")
      ->type_name("N")
      ->check(countRange())
      ->capture_default_str();
  app.add_option("--build-threads", o.buildThreads, "threads for building, 0 for all")
      ->type_name("N")
      ->capture_default_str();
}

void declareErrorsAndChecks(CLI::App& app, BenchOptions& o, OptionTexts& texts) {
  app.add_option("--check", texts.checks,
                 "leaks (rays out of closed surfaces), sheets (rays through random sheets), "
                 "crossings (hits that a filter\nreceives if it rejects all), shadows (secondary rays compared with "
                 "GRID's), offsets (shadows at many offsets)")
      ->type_name("LIST");
  app.add_option("--check-rays", o.checks.rays, "rays per representation for leaks and sheets")
      ->type_name("N")
      ->check(countRange())
      ->capture_default_str();
  app.add_flag("--check-packets", o.checks.packets,
               "trace these rays in coherent packets as wide as the instruction set");
  app.add_option("--position", texts.position, "position to which models are moved: x,y,z")->type_name("P");
  app.add_option("--max-error-diagonals", o.maxError,
                 "bound on cVERT's spacing, and on the thickness of leaves if the frame level is auto, in diagonals\n"
                 "of the cage's bounding box; 0: cVERT stores vertices exactly")
      ->type_name("E");
  app.add_option("--reference-level", o.referenceLevel,
                 "also measure errors against GRID at this level; this also fixes the view for all levels")
      ->type_name("L");
  app.add_option("--true-surface", o.trueHits,
                 "number of random hits per view that are compared with the displaced limit surface, 0 to skip")
      ->type_name("N")
      ->check(countRange())
      ->capture_default_str();
}

void declareOutput(CLI::App& app, BenchOptions& o, OptionTexts& texts) {
  app.add_option("--pictures", o.pictures, "folder for shaded pictures and error maps")->type_name("DIR");
  app.add_option("--samples", o.samples, "samples per pixel of shaded pictures; error maps have one")
      ->type_name("N")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  app.add_option("--picture-level", texts.pictureLevels, "levels for which pictures are written [all]")
      ->type_name("LIST");
  app.add_option("--json", o.json, "file for the measurements, as JSON")->type_name("FILE");
  app.add_flag("--about", texts.about, "print commit, instruction sets and scenes as JSON, and exit");
}

std::vector<BenchScene> readScenes(const OptionTexts& texts) {
  SceneSettings settings = texts.settings;
  applyFileArguments(texts.files, settings);
  if (!settings.meshPath.empty())
    throw Error(settings.meshPath +
                ": cbvh_bench does not measure meshes: expected a cage (OBJ), or cbvh_render --mesh "
                "with --compare");
  if (texts.scenes.empty() || !settings.cagePath.empty() || !settings.savedPath.empty()) {
    settings.scene = texts.scenes;
    validateScene(settings);
    return {{std::filesystem::path(settings.cagePath).stem().string(), settings}};
  }
  if (settings.amplitude)
    throw Error("--amplitude needs --cage: expected the amplitude of a scene after a colon, as in cube:0.45");
  std::vector<BenchScene> scenes;
  for (const std::string& entry : split("--scene", texts.scenes)) scenes.push_back(parseScene(entry, settings));
  return scenes;
}

void readSurfaces(const OptionTexts& texts, BenchOptions& o) {
  o.scenes = readScenes(texts);
  o.size = parseImageSize(texts.size);
  o.views = parseViews(texts.views.empty() ? std::vector<std::string>{"full"} : texts.views, o.size);
  o.levels = parseIntegers("--level", texts.levels, maxLevel);
  if (!texts.pictureLevels.empty()) o.pictureLevels = parseIntegers("--picture-level", texts.pictureLevels, maxLevel);
  if (!texts.checks.empty())
    for (const std::string& entry : split("--check", texts.checks)) o.checks.add(entry);
  const bool moves = !texts.settings.motion.empty() || !texts.settings.cageEnds.empty();
  if (moves && !texts.checks.empty())
    throw Error("--check supports only static models: expected no --motion or --cage-end");
  if (!texts.position.empty()) o.position = parsePosition(texts.position);
  if (o.maxError) requireNotNegative("--max-error-diagonals", *o.maxError);
  o.representations = parseAll(texts.representations, texts.frameLevels);
}

void readLibraries(const OptionTexts& texts, BenchOptions& o) {
  if (!texts.libraries.empty() && texts.device != "cpu")
    throw Error("--library traces on the CPU: expected no --library with --device " + texts.device);
  validateTraceDevice(o.device = texts.device);
  if (texts.libraries.empty()) o.libraries.emplace_back();
  else o.libraries = openLibraries(split("--library", texts.libraries));
}

void readCombinations(const OptionTexts& texts, Machine machine, BenchOptions& o) {
  constexpr int maxThreads = 1024; // more is probably a typing error
  if (!texts.libraries.empty())    // instead of the program's own library's
    machine.isas = commonIsas(o.libraries);
  for (const std::string& entry : split("--isa", texts.isas)) {
    o.isas.push_back(entry == "best" ? bestIsa(machine) : entry);
    requireIsa(machine, o.isas.back());
  }
  if (o.device != "cpu" && (texts.threads != "1" || texts.modes != "single"))
    throw Error("--threads and --mode are for the CPU: expected neither with --device " + o.device);
  if (o.device != "cpu" && o.checks.packets)
    throw Error("--check-packets is for the CPU: expected no packets with --device " + o.device);
  if (o.device != "cpu" && o.checks.crossings)
    throw Error("--check crossings needs filter functions, which only the CPU calls: expected no --device " + o.device);
  for (int n : parseIntegers("--threads", texts.threads, maxThreads)) o.threads.push_back(threadCount(n));
  for (const std::string& entry : split("--ray-set", texts.sets)) o.sets.push_back(parseRaySet(entry));
  for (const std::string& entry : split("--query", texts.queries)) o.queries.push_back(parseQuery(entry));
  for (const std::string& entry : split("--mode", texts.modes)) o.modes.push_back(parseTraceMode(entry));
}

void validateNumbers(const BenchOptions& o) {
  constexpr int maxRounds = 1000; // more is probably a typing error
  if (o.repeat < 0 || o.repeat > maxRounds)
    throw Error("invalid --repeat " + std::to_string(o.repeat) + ": expected 0 to " + std::to_string(maxRounds));
  requireNotNegative("--ray-offset", o.rayOffset);
  if (o.buildThreads < 0)
    throw Error("invalid --build-threads " + std::to_string(o.buildThreads) + ": expected 0 (all) or more");
  if (o.referenceLevel < -1 || o.referenceLevel > maxLevel)
    throw Error("invalid --reference-level " + std::to_string(o.referenceLevel) + ": expected " + levelRange());
}

} // namespace

std::optional<BenchOptions> parseBenchOptions(int argc, char** argv, const Machine& machine) {
  BenchOptions o;
  OptionTexts texts;
  CLI::App app("Measures representations of displaced subdivision surfaces: memory, build time, speed and error of\n"
               "all combinations of the listed values, interleaved. Always includes GRID; speeds are relative to it.",
               "cbvh_bench");
  declareLists(app, texts);
  declareMeasurement(app, o, texts);
  declareErrorsAndChecks(app, o, texts);
  declareOutput(app, o, texts);
  if (!parseCommandLine(app, argc, argv)) return std::nullopt;
  if (texts.about) {
    writeStandardOutput(formatAbout(machine) + "\n");
    return std::nullopt;
  }
  readSurfaces(texts, o);
  readLibraries(texts, o);
  readCombinations(texts, machine, o);
  validateNumbers(o);
  for (const BenchScene& scene : o.scenes) validateOutputs(scene.settings, {{"--json", o.json}});
  o.command = commandLine(argc, argv);
  return o;
}

} // namespace programs
