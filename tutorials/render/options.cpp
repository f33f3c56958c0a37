// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"
#include "basics/error.h"
#include "programs/command_line.h"
#include "programs/opened_files.h"
#include "programs/outputs.h"
#include "programs/view_options.h"

#include <algorithm>

namespace programs {
namespace {

/* Unparsed options, with the defaults that --help shows. */
struct OptionTexts {
  std::vector<std::string> files;
  std::string representations = optionNameOf(preferredKind), size = "1024x1024", crop;
  std::string colors = "neutral", shutter = "0,1";
  LevelOptions levels;
  bool compare = false;
  std::optional<size_t> trueHits;
};

/* In the order of --help. */

void declarePictures(CLI::App& app, Options& o, OptionTexts& texts) {
  addFileArguments(app, texts.files, true);
  app.add_option("--scene", o.scene.scene, "instead of files: generated scene, " + listOfScenes())->type_name("NAME");
  addMeshOption(app, o.scene);
  addSceneOptions(app, o.scene);
  CLI::Option* const list =
      app.add_option(
             "--representation", texts.representations,
             "comma-separated list of " + listOfRepresentations(", ") +
                 "; a frame level may follow after ^ or "
                 ":. Several representations are compared; errors are measured against grid and naive, if listed")
          ->type_name("LIST")
          ->capture_default_str();
  app.add_flag("--compare", texts.compare,
               "compare " + defaultRepresentations() + ", or " + meshRepresentations() + " for --mesh")
      ->excludes(list);
  addViewLevelOptions(app, texts.levels);
  app.add_option("--view", o.view, "full, close, or ex,ey,ez,lx,ly,lz,fov")->type_name("VIEW")->capture_default_str();
  app.add_option("--size", texts.size, "picture size")->type_name("WxH")->capture_default_str();
  app.add_option("--crop", texts.crop,
                 "render only this part of the picture, columns x0 to x1-1 and rows y0 to y1-1 from the upper left; "
                 "parts can be joined without seams. In files of --exr the part is the data window; a PNG contains "
                 "only the part")
      ->type_name("x0,y0,x1,y1");
  app.add_option("--samples", o.samples, "samples per pixel of shaded pictures; error maps and all figures have one")
      ->type_name("N")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  addShutterOption(app, texts.shutter);
  app.add_option("--colors", texts.colors,
                 "neutral: gray from both sides; sides: magenta if the normal points away from the camera, because it "
                 "is flipped, or because the inside of the surface is visible")
      ->type_name("COLORS")
      ->check(CLI::IsMember({"neutral", "sides"}))
      ->capture_default_str();
  app.add_option("--output", o.output, "folder for the pictures, created if necessary")
      ->type_name("DIR")
      ->capture_default_str();
  app.add_option("--export", o.exportPath,
                 "also write the surface as ctile and cvert store it, as OBJ quads that --mesh reads")
      ->type_name("FILE");
  app.add_option("--save", o.savePath,
                 "also write the compressed scene to a file (.cbvh), which --load opens at once; a herd is written "
                 "copy by copy, and an interrupted run is resumed")
      ->type_name("FILE");
  app.add_option("--load", o.loadPath, "instead of files and scenes: file that --save wrote, with any name")
      ->type_name("FILE");
  app.add_option("--join", o.join,
                 "instead of rendering: join pictures of --crop, whole rows from top to bottom, into FILE; with "
                 "--size, it must have this size")
      ->type_name("FILE PART...")
      ->expected(2, 1 << 20);
  app.add_flag("--exr", o.exr,
               "also write linear colors and hits as OpenEXR: position, distance, normal, u, v and primID");
}

void declareMeasurement(CLI::App& app, Options& o, OptionTexts& texts) {
  app.add_flag("--speed", o.speed,
               "measure rays per second of each representation, also relative to GRID if it is listed");
  app.add_option("--rays", o.rays, "rays per speed measurement, 0 for one per pixel")
      ->type_name("N")
      ->check(countRange())
      ->capture_default_str();
  app.add_option("--repeat", o.repeat,
                 "rounds of a speed measurement, whose median is reported; up to 4 times as many "
                 "if they differ by more than 10%")
      ->type_name("N")
      ->capture_default_str();
  app.add_option("--ray-offset", o.rayOffset,
                 "distance of bounced rays' origins from the surface, in diagonals of the bounding box")
      ->type_name("D")
      ->capture_default_str();
  app.add_option("--ambient", o.ambientRays,
                 "also write pictures of ambient occlusion with this number of rays per pixel, from each "
                 "representation's own hits, next to GRID's")
      ->type_name("N")
      ->check(CLI::Range(0, 4096));
  app.add_option("--true-surface", texts.trueHits,
                 "number of random hits that are compared with the displaced limit surface, 0 to skip [20000 if "
                 "several representations of a static surface are compared]")
      ->type_name("N")
      ->check(countRange());
  app.add_option("--threads", o.build.threads, "threads for building and rendering, 0 for all")
      ->type_name("N")
      ->capture_default_str();
  addDeviceOption(app, o.build.device);
  addIsaOption(app, o.build.isa);
  app.add_flag("--details", o.details, "print all rows of the table");
  app.add_option("--json", o.json, "also write all numbers to this file")->type_name("FILE");
}

/* Results of comparisons must not depend on the view unless auto is given. */
void chooseLevel(const CLI::App& app, const OptionTexts& texts, Options& o) {
  const bool isGiven = app.count("--level") != 0;
  const auto triangulated = std::find_if(o.representations.begin(), o.representations.end(),
                                         [](const Representation& r) { return r.isTriangulated(); });
  const bool isTriangulated = triangulated != o.representations.end();
  if (o.autoLevel && isGiven && isTriangulated)
    throw Error("--level auto does not support " + optionNameOf(triangulated->kind) +
                ", which has one level for all edges: expected " + levelRange());
  if (!isGiven && (o.compares() || isTriangulated || o.speed)) o.autoLevel = false;
  if (!o.scene.meshPath.empty()) o.autoLevel = false;
  if (!o.autoLevel && app.count("--quad-size")) throw Error("--quad-size needs --level auto");
  o.quadSize = texts.levels.quadSize;
  o.maxPixelError = texts.levels.maxPixelError.value_or(o.autoLevel ? autoPixelError : 0.0f);
}

void read(const CLI::App& app, const OptionTexts& texts, Options& o) {
  o.size = parseImageSize(texts.size);
  o.hasSize = app.count("--size") != 0;
  if (!o.join.empty()) {
    for (const CLI::Option* option : app.get_options())
      if (option->count() && option->get_name() != "--join" && option->get_name() != "--size")
        throw Error("--join renders nothing: expected no " + option->get_name());
    return;
  }
  if (o.loadPath.empty()) {
    applyFileArguments(texts.files, o.scene);
    o.loadPath = o.scene.savedPath;
  } else if (!(texts.files.empty() && o.scene.scene.empty() && o.scene.cagePath.empty() && o.scene.meshPath.empty()))
    throw Error("--load replaces files, --scene, --cage and --mesh: expected none of them");
  const bool needsModel =
      !o.exportPath.empty() || o.ambientRays || texts.trueHits.value_or(0) || o.build.device != "cpu";
  if (!o.loadPath.empty() && (!o.savePath.empty() || needsModel))
    throw Error(o.loadPath + ": a file has no model and is traced on the CPU: expected no --save, --export, --ambient, "
                             "--true-surface or --device");
  if (o.savesCopyByCopy() && needsModel)
    throw Error("--save of a herd writes it copy by copy, and traces the file on the CPU: expected no --export, "
                "--ambient, --true-surface or --device");
  if (o.loadPath.empty()) validateScene(o.scene);
  else rejectModelOptions(app, o.loadPath);
  o.autoLevel = parseLevel(texts.levels, o.build.level);
  validateBuild(o.build);
  if (o.repeat < 1) throw Error("invalid --repeat " + std::to_string(o.repeat) + ": expected at least 1");
  requireNotNegative("--ray-offset", o.rayOffset);
  o.scene.threads = o.build.threads;
  o.colors = texts.colors == "sides" ? HitColors::Sides : HitColors::Neutral;
  o.crop = parseCrop(texts.crop, o.size);
  o.shutter = parseShutter(texts.shutter);
  const bool isMesh = !o.scene.meshPath.empty(), moves = !o.scene.motion.empty() || !o.scene.cageEnds.empty();
  const std::string compared = isMesh ? meshRepresentations() : defaultRepresentations();
  o.representations =
      parseRepresentationOptions(texts.compare ? compared : texts.representations, texts.levels.frameLevel);
  chooseLevel(app, texts, o);
  o.trueHits = texts.trueHits.value_or(o.compares() && !isMesh && !moves ? 20000 : 0);
  if (isMesh && o.trueHits) throw Error("--true-surface needs a cage or a scene: a mesh is its own surface");
  if (moves && o.trueHits)
    throw Error("--true-surface supports only static models: expected no --motion or --cage-end");
  const auto isExact = [](const Representation& r) { return r.isExact(); };
  if (!o.exportPath.empty() && std::none_of(o.representations.begin(), o.representations.end(), isExact))
    throw Error("--export writes the surface of ctile and cvert: expected one of them in --representation");
  if (!texts.crop.empty() && (o.compares() || o.speed || o.ambientRays || texts.trueHits.value_or(0)))
    throw Error("--crop renders a part of a single picture: expected no comparison, --speed, --ambient or "
                "--true-surface");
  if (!o.savePath.empty() && (o.compares() || !o.representations[0].isCompressed()))
    throw Error("--save supports a single compressed representation: expected one, neither grid, naive nor "
                "naive-compact");
  if (o.view != "full" && o.view != "close") parseView(o.view, {0, 1, 0}, o.size);
  SceneSettings inputs = o.scene;
  inputs.savedPath = o.loadPath;
  validateOutputs(inputs, {{"--save", o.savePath}, {"--export", o.exportPath}, {"--json", o.json}});
}

} // namespace

std::optional<Options> parseOptions(int argc, char** argv) {
  Options o;
  OptionTexts texts;
  CLI::App app("Renders a displaced subdivision surface, by default in cTILE. Several representations are rendered\n"
               "one after the other, and compared in memory, build time, error and speed.",
               "cbvh_render");
  declarePictures(app, o, texts);
  declareMeasurement(app, o, texts);
  if (!parseCommandLine(app, argc, argv)) return std::nullopt;
  read(app, texts, o);
  return o;
}

} // namespace programs
