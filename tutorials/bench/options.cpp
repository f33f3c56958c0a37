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

namespace cbvh {
namespace {

std::vector<std::string> split(const std::string& option, const std::string& list)
{
  std::vector<std::string> words;
  for (size_t begin = 0; begin <= list.size();)
  {
    const size_t end = std::min(list.find(',', begin), list.size());
    words.push_back(list.substr(begin, end - begin));
    begin = end + 1;
    if (words.back().empty())
      throw Error(option + " '" + list + "' has an empty entry");
    if (std::count(words.begin(), words.end(), words.back()) > 1)
      throw Error(option + " names '" + words.back() + "' twice");
  }
  return words;
}

/* A list of numbers from 0 to `most`. */
std::vector<int> parseIntegers(const std::string& option, const std::string& list, int most)
{
  std::vector<int> numbers;
  for (const std::string& word : split(option, list))
  {
    int value = 0;
    const char* const end = word.data() + word.size();
    const auto result = std::from_chars(word.data(), end, value);
    if (result.ec != std::errc() || result.ptr != end || value < 0 || value > most)
      throw Error(option + " '" + word + "' is not a number from 0 to " + std::to_string(most));
    numbers.push_back(value);
  }
  return numbers;
}

/* settings: of all scenes on the command line. */
BenchScene parseScene(const std::string& word, const SceneSettings& settings)
{
  BenchScene scene{word, settings};
  scene.label += settings.rough ? "-rough" : "";
  scene.label += settings.mapping.empty() ? "" : "-" + settings.mapping;
  scene.label += settings.count ? "-" + std::to_string(*settings.count) : "";
  scene.label += settings.motion.empty() ? "" : "-" + settings.motion;
  const size_t mark = word.find(':');
  scene.settings.scene = word.substr(0, mark);
  if (mark != std::string::npos)
  {
    float amplitude = 0;
    const char* const end = word.data() + word.size();
    const auto result = std::from_chars(word.data() + mark + 1, end, amplitude);
    if (result.ec != std::errc() || result.ptr != end || !std::isfinite(amplitude))
      throw Error("--scene '" + word + "': the amplitude after the colon is not a number");
    scene.settings.amplitude = amplitude;
  }
  validateScene(scene.settings);
  return scene;
}

/* "full,close" are two views, "ex,ey,ez,lx,ly,lz,fov" is one. */
std::vector<std::string> parseViews(const std::vector<std::string>& given, ImageSize size)
{
  std::vector<std::string> views;
  for (const std::string& text : given)
  {
    if (std::count(text.begin(), text.end(), ',') == 6)
    {
      parseView(text, {0, 1, 0}, size);
      views.push_back(text);
      continue;
    }
    for (const std::string& word : split("--view", text))
    {
      if (word != "full" && word != "close")
        parseView(word, {0, 1, 0}, size);
      views.push_back(word);
    }
  }
  return views;
}

std::vector<Representation> parseAll(const std::string& names, const std::string& frameLevels)
{
  std::vector<Representation> all;
  try
  {
    for (const std::string& level : split("--frame-level", frameLevels))
      for (const Representation& r : parseRepresentations(names, parseFrameLevel(level)))
      {
        const auto same = [&](const Representation& other) { return other.label() == r.label(); };
        if (std::none_of(all.begin(), all.end(), same))
          all.push_back(r);
      }
  }
  catch (const Error& e)
  {
    throw Error(std::string("--representation or --frame-level: ") + e.what());
  }
  return all;
}

std::string commandLine(int argc, char** argv)
{
  std::string command = std::filesystem::path(argv[0]).filename().string();
  for (int i = 1; i < argc; i++)
  {
    const std::string word = argv[i];
    const bool plain = !word.empty() && word.find_first_of(" '\"\\$^*?;&|<>()") == std::string::npos;
    command += plain ? " " + word : " '" + word + "'";
  }
  return command;
}

RaySet parseRaySet(const std::string& word)
{
  for (RaySet set : {Coherent, Incoherent})
    if (word == raySetName(set))
      return set;
  throw Error("unknown --set '" + word + "', known are coherent and incoherent");
}

/* What the command line says in words of its own, with the defaults that --help names. */
struct Words
{
  std::vector<std::string> files;
  SceneSettings settings; // of all scenes
  std::string scenes, libraries, levels = "6", representations = defaultRepresentations(), frameLevels = "auto";
  std::string isas = "best", device = "cpu", threads = "1", sets = "coherent,incoherent", queries = "closest", modes = "single";
  std::string size = "768x768", pictureLevels, checks, position;
  std::vector<std::string> views;
  bool about = false;
};

/* The options, in the order of --help. */

void declareLists(CLI::App& app, Words& words)
{
  addFileArguments(app, words.files);
  app.add_option("--scene", words.scenes, "comma list of " + listOfScenes() + "; an amplitude of its own after a colon")
    ->type_name("LIST");
  addSceneOptions(app, words.settings);
  app.add_option("--view", words.views, "full, close, or ex,ey,ez,lx,ly,lz,fov; may be given several times")
    ->type_name("LIST")->default_str("full");
  app.add_option("--level", words.levels, "tessellation levels, " + levelRange())->type_name("LIST")->capture_default_str();
  app.add_option("--representation", words.representations,
                 "of " + listOfRepresentations(", ") + "; a frame level of its own after ^ or :")
    ->type_name("LIST")->capture_default_str();
  app.add_option("--frame-level", words.frameLevels, "frame levels, at which local frames start: " + levelRange() + ", or auto")
    ->type_name("LIST")->capture_default_str();
  app.add_option("--library", words.libraries,
                 "builds of libembree3.so.3, or folders that have one, in place of the program's own: speeds are relative to\n"
                 "the first, too, and hits are compared with its")
    ->type_name("LIST");
  app.add_option("--isa", words.isas, "widest instruction sets: best, sse2, sse4.2, avx, avx2, avx512")
    ->type_name("LIST")->capture_default_str();
  addDeviceOption(app, words.device);
  app.add_option("--threads", words.threads, "numbers of threads that trace, 0 for all")
    ->type_name("LIST")->capture_default_str();
  app.add_option("--set", words.sets, "ray sets: coherent, incoherent")->type_name("LIST")->capture_default_str();
  app.add_option("--query", words.queries, "closest, any")->type_name("LIST")->capture_default_str();
  app.add_option("--mode", words.modes, "single, packet4, packet8, packet16, stream")
    ->type_name("LIST")->capture_default_str();
}

void declareMeasurement(CLI::App& app, BenchOptions& o, Words& words)
{
  app.add_option("--rays", o.rays, "rays in a measurement, 0 for one a pixel")->type_name("N")->capture_default_str();
  app.add_option("--repeat", o.repeat, "measurements of each combination, 0 for no speed")
    ->type_name("N")->capture_default_str();
  app.add_option("--size", words.size, "picture size")->type_name("WxH")->capture_default_str();
  app.add_option("--ray-offset", o.rayOffset,
                 "distance of bounced rays' origins from the surface, in bounding-box diagonals")
    ->type_name("D")->capture_default_str();
  app.add_option("--seed", o.seed, "of the bounced rays and of the hits compared with the true surface")
    ->type_name("N")->capture_default_str();
  app.add_option("--build-threads", o.buildThreads, "threads that build, 0 for all")
    ->type_name("N")->capture_default_str();
}

void declareErrorsAndChecks(CLI::App& app, BenchOptions& o, Words& words)
{
  app.add_option("--check", words.checks,
                 "leaks (rays out of closed surfaces), sheets (rays through random sheets), "
                 "crossings (that a filter sees which rejects all), shadows (secondary rays from own hits against GRID's),\n"
                 "offsets (shadows at many offsets)")
    ->type_name("LIST");
  app.add_option("--check-rays", o.checks.rays, "rays that look for leaks or cross sheets, a representation")
    ->type_name("N")->capture_default_str();
  app.add_flag("--check-packets", o.checks.packets, "these rays go in packets as wide as the instruction set, and are said to be coherent");
  app.add_option("--position", words.position, "moves models there: x,y,z")->type_name("P");
  app.add_option("--max-error", o.maxError, "bound on the thickness of leaves where the frame level is auto, and on cVERT's spacing, in\n"
                 "bounding-box diagonals of the cage; 0: cVERT stores vertices exactly")->type_name("E");
  app.add_option("--reference-level", o.referenceLevel,
                 "measure errors against GRID at this level, too, which also fixes the view for all levels")
    ->type_name("L");
  app.add_option("--true-surface", o.trueHits,
                 "hits of a view compared with the displaced limit surface itself, drawn at random, 0 for none")
    ->type_name("N")->capture_default_str();
}

void declareOutput(CLI::App& app, BenchOptions& o, Words& words)
{
  app.add_option("--pictures", o.pictures, "folder for shaded pictures and error maps")->type_name("DIR");
  app.add_option("--samples", o.samples, "samples a pixel of shaded pictures; error maps have one")
    ->type_name("N")->check(CLI::Range(1, 4096))->capture_default_str();
  app.add_option("--picture-level", words.pictureLevels, "levels that get pictures, else all")->type_name("LIST");
  app.add_option("--json", o.json, "write the measurements there")->type_name("FILE");
  app.add_flag("--about", words.about, "print commit, instruction sets and scenes as JSON, and end");
}

/* A cage, or scenes by their names. */
std::vector<BenchScene> readScenes(const Words& words)
{
  SceneSettings settings = words.settings;
  applyFileArguments(words.files, settings);
  if (words.scenes.empty() || !settings.cagePath.empty() || !settings.savedPath.empty())
  {
    settings.scene = words.scenes;
    validateScene(settings);
    return {{std::filesystem::path(settings.cagePath).stem().string(), settings}};
  }
  if (settings.amplitude)
    throw Error("--amplitude belongs to --cage; one for a scene comes after a colon, cube:0.45");
  std::vector<BenchScene> scenes;
  for (const std::string& word : split("--scene", words.scenes))
    scenes.push_back(parseScene(word, settings));
  return scenes;
}

/* What is built, and looked at. */
void readSurfaces(const Words& words, BenchOptions& o)
{
  o.scenes = readScenes(words);
  o.size = parseImageSize(words.size);
  o.views = parseViews(words.views.empty() ? std::vector<std::string>{"full"} : words.views, o.size);
  o.levels = parseIntegers("--level", words.levels, maxLevel);
  if (!words.pictureLevels.empty())
    o.pictureLevels = parseIntegers("--picture-level", words.pictureLevels, maxLevel);
  if (!words.checks.empty())
    for (const std::string& word : split("--check", words.checks))
      o.checks.add(word);
  const bool moves = !words.settings.motion.empty() || !words.settings.cageEnds.empty();
  if (moves && !words.checks.empty())
    throw Error("--check is of models that stand still: leave out --motion and --cage-end");
  if (!words.position.empty())
    o.position = parsePosition(words.position);
  if (o.maxError)
    requireNotNegative("--max-error", *o.maxError);
  o.representations = parseAll(words.representations, words.frameLevels);
}

/* What traces. */
void readLibraries(const Words& words, BenchOptions& o)
{
  if (!words.libraries.empty() && words.device != "cpu")
    throw Error("--library is of the processor: with --device " + words.device + " leave it out");
  validateTraceDevice(o.device = words.device);
  if (words.libraries.empty())
    o.libraries.emplace_back();
  else
    o.libraries = openLibraries(split("--library", words.libraries));
}

/* How it is measured. */
void readCombinations(const Words& words, Machine machine, BenchOptions& o)
{
  constexpr int mostThreads = 1024; // more is a slip of the keyboard
  if (!words.libraries.empty()) // not those of this program's own
    machine.isas = commonIsas(o.libraries);
  for (const std::string& word : split("--isa", words.isas))
  {
    o.isas.push_back(word == "best" ? bestIsa(machine) : word);
    requireIsa(machine, o.isas.back());
  }
  if (o.device != "cpu" && (words.threads != "1" || words.modes != "single"))
    throw Error("--threads and --mode are of the processor: with --device " + o.device + " leave them out");
  if (o.device != "cpu" && o.checks.packets)
    throw Error("--check-packets is of the processor: with --device " + o.device + " leave it out");
  if (o.device != "cpu" && o.checks.crossings)
    throw Error("--check crossings calls a filter, which --device " + o.device + " cannot");
  for (int n : parseIntegers("--threads", words.threads, mostThreads))
    o.threads.push_back(threadCount(n));
  for (const std::string& word : split("--set", words.sets))
    o.sets.push_back(parseRaySet(word));
  for (const std::string& word : split("--query", words.queries))
    o.queries.push_back(parseQuery(word));
  for (const std::string& word : split("--mode", words.modes))
    o.modes.push_back(parseTraceMode(word));
}

void validateNumbers(const BenchOptions& o)
{
  constexpr int mostRounds = 1000; // as above
  if (o.repeat < 0 || o.repeat > mostRounds)
    throw Error("--repeat must be 0 to " + std::to_string(mostRounds));
  requireNotNegative("--ray-offset", o.rayOffset);
  if (o.buildThreads < 0)
    throw Error("--build-threads must not be negative");
  if (o.referenceLevel < -1 || o.referenceLevel > maxLevel)
    throw Error("--reference-level must be " + levelRange());
}

} // namespace

std::optional<BenchOptions> parseBenchOptions(int argc, char** argv, const Machine& machine)
{
  BenchOptions o;
  Words words;
  CLI::App app("Measures representations of displaced subdivision surfaces: memory, build, speed and error of every\n"
               "combination of what the lists name, interleaved. GRID is always among them: speeds are relative to it.",
               "cbvh_bench");
  declareLists(app, words);
  declareMeasurement(app, o, words);
  declareErrorsAndChecks(app, o, words);
  declareOutput(app, o, words);
  if (!parseCommandLine(app, argc, argv))
    return std::nullopt;
  if (words.about)
  {
    writeStandardOutput(formatAbout(machine) + "\n");
    return std::nullopt;
  }
  readSurfaces(words, o);
  readLibraries(words, o);
  readCombinations(words, machine, o);
  validateNumbers(o);
  for (const BenchScene& scene : o.scenes)
    validateOutputs(scene.settings, {{"--json", o.json}});
  o.command = commandLine(argc, argv);
  return o;
}

} // namespace cbvh
