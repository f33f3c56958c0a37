// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"
#include "json.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "programs/command_line.h"
#include "programs/view_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>

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

int parseInteger(const std::string& option, const std::string& word, int lower, int upper)
{
  int value = 0;
  const char* const end = word.data() + word.size();
  const auto result = std::from_chars(word.data(), end, value);
  if (result.ec != std::errc() || result.ptr != end || value < lower || value > upper)
    throw Error(option + " '" + word + "' is not a number from " + std::to_string(lower) + " to " +
                std::to_string(upper));
  return value;
}

/* settings: of all scenes on the command line. */
BenchScene parseScene(const std::string& word, const SceneSettings& settings)
{
  BenchScene scene{word, settings};
  scene.label += settings.rough ? "-rough" : "";
  scene.label += settings.mapping.empty() ? "" : "-" + settings.mapping;
  scene.label += settings.count ? "-" + std::to_string(*settings.count) : "";
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

} // namespace

std::optional<BenchOptions> parseBenchOptions(int argc, char** argv, const Machine& machine)
{
  BenchOptions o;
  SceneSettings settings;
  std::string scenes, levels = "6", representations = "naive,grid,cgrid,cvoxel,cleaf", frameLevels = "2";
  std::string isas = "best", threads = "1", sets = "coherent,incoherent", queries = "closest", modes = "single";
  std::string size = "768x768";
  std::string pictureLevels, checks, position;
  std::vector<std::string> views;
  bool about = false;

  CLI::App app("Measures representations of displaced subdivision surfaces: memory, build, speed and error of every\n"
               "combination of what the lists name, interleaved. GRID is always among them: speeds are relative to it.",
               "cbvh_bench");
  app.add_option("--scene", scenes, "comma list of " + listOfScenes() + "; an amplitude of its own after a colon")
    ->type_name("LIST");
  addSceneOptions(app, settings);
  app.add_option("--view", views, "full, close, or ex,ey,ez,lx,ly,lz,fov; may be given several times")
    ->type_name("LIST")->default_str("full");
  app.add_option("--level", levels, "subdivision levels, 0 to 8")->type_name("LIST")->capture_default_str();
  app.add_option("--representation", representations,
                 "of naive, grid, cgrid, cvoxel, cleaf; a frame level of its own after ^ or :")
    ->type_name("LIST")->capture_default_str();
  app.add_option("--frame-level", frameLevels, "levels at which local frames start: 0 to 8, or auto")
    ->type_name("LIST")->capture_default_str();
  app.add_option("--isa", isas, "widest instruction sets: best, sse2, sse4.2, avx, avx2, avx512")
    ->type_name("LIST")->capture_default_str();
  app.add_option("--threads", threads, "numbers of threads that trace, 0 for all")
    ->type_name("LIST")->capture_default_str();
  app.add_option("--set", sets, "ray sets: coherent, incoherent")->type_name("LIST")->capture_default_str();
  app.add_option("--query", queries, "closest, any")->type_name("LIST")->capture_default_str();
  app.add_option("--mode", modes, "single, packet4, packet8, packet16, stream")
    ->type_name("LIST")->capture_default_str();
  app.add_option("--rays", o.rays, "rays in a measurement, 0 for one a pixel")->type_name("N")->capture_default_str();
  app.add_option("--repeat", o.repeat, "measurements of each combination, 0 for no speed")
    ->type_name("N")->capture_default_str();
  app.add_option("--size", size, "picture size")->type_name("WxH")->capture_default_str();
  app.add_option("--ray-offset", o.rayOffset,
                 "distance of bounced rays' origins from the surface, in bounding-box diagonals")
    ->type_name("D")->capture_default_str();
  app.add_option("--seed", o.seed, "of the bounced rays and of the hits compared with the true surface")->type_name("N")->capture_default_str();
  app.add_option("--build-threads", o.buildThreads, "threads that build, 0 for all")
    ->type_name("N")->capture_default_str();
  app.add_option("--check", checks,
                 "leaks (rays out of closed surfaces), sheets (rays through random sheets), shadows (secondary rays from own hits against GRID's),\n"
                 "offsets (shadows at many offsets)")
    ->type_name("LIST");
  app.add_option("--check-rays", o.checks.rays, "rays that look for leaks or cross sheets, a representation")
    ->type_name("N")->capture_default_str();
  app.add_option("--position", position, "moves models there: x,y,z")->type_name("P");
  app.add_option("--max-error", o.maxError, "bound on the thickness of leaves where the frame level is auto, in\n"
                 "bounding-box diagonals of the cage")->type_name("E");
  app.add_option("--reference-level", o.referenceLevel,
                 "measure errors against GRID at this level, too, which also fixes the view for all levels")
    ->type_name("L");
  app.add_option("--true-surface", o.trueHits,
                 "hits of a view compared with the displaced limit surface itself, drawn at random, 0 for none")
    ->type_name("N")->capture_default_str();
  app.add_option("--pictures", o.pictures, "folder for shaded pictures and error maps")->type_name("DIR");
  app.add_option("--picture-level", pictureLevels, "levels that get pictures, else all")->type_name("LIST");
  app.add_option("--maps", o.maps, "folder for generated height maps, else a temporary one")->type_name("DIR");
  app.add_option("--json", o.json, "write the measurements there")->type_name("FILE");
  app.add_flag("--about", about, "print commit, instruction sets and scenes as JSON, and end");
  if (!parseCommandLine(app, argc, argv))
    return std::nullopt;

  if (about)
  {
    std::puts(formatAbout(machine).c_str());
    return std::nullopt;
  }
  if (scenes.empty() || !settings.cagePath.empty())
  {
    settings.scene = scenes;
    validateScene(settings);
    o.scenes.push_back({std::filesystem::path(settings.cagePath).stem().string(), settings});
  }
  else if (settings.amplitude)
    throw Error("--amplitude belongs to --cage; one for a scene comes after a colon, cube:0.45");
  else
    for (const std::string& word : split("--scene", scenes))
      o.scenes.push_back(parseScene(word, settings));
  o.size = parseImageSize(size);
  o.views = parseViews(views.empty() ? std::vector<std::string>{"full"} : views, o.size);
  for (const std::string& word : split("--level", levels))
    o.levels.push_back(parseInteger("--level", word, 0, maxLevel));
  if (!pictureLevels.empty())
    for (const std::string& word : split("--picture-level", pictureLevels))
      o.pictureLevels.push_back(parseInteger("--picture-level", word, 0, maxLevel));
  if (!checks.empty())
    for (const std::string& word : split("--check", checks))
      o.checks.add(word);
  if (!position.empty())
    o.position = parsePosition(position);
  if (!(o.maxError >= 0.0f) || !std::isfinite(o.maxError))
    throw Error("--max-error must be finite and not negative");
  o.representations = parseAll(representations, frameLevels);
  for (const std::string& word : split("--isa", isas))
  {
    o.isas.push_back(word == "best" ? bestIsa(machine) : word);
    requireIsa(machine, o.isas.back());
  }
  for (const std::string& word : split("--threads", threads))
    o.threads.push_back(threadCount(parseInteger("--threads", word, 0, 1024)));
  for (const std::string& word : split("--set", sets))
    o.sets.push_back(parseRaySet(word));
  for (const std::string& word : split("--query", queries))
    o.queries.push_back(parseQuery(word));
  for (const std::string& word : split("--mode", modes))
    o.modes.push_back(parseTraceMode(word));
  if (o.repeat < 0 || o.repeat > 1000)
    throw Error("--repeat must be 0 to 1000");
  if (!(o.rayOffset >= 0.0f) || !std::isfinite(o.rayOffset))
    throw Error("--ray-offset must be finite and not negative");
  if (o.buildThreads < 0)
    throw Error("--build-threads must not be negative");
  if (o.referenceLevel < -1 || o.referenceLevel > maxLevel)
    throw Error("--reference-level must be 0 to " + std::to_string(maxLevel));
  o.command = commandLine(argc, argv);
  return o;
}

} // namespace cbvh
