// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"
#include "basics/error.h"
#include "programs/command_line.h"
#include "programs/opened_files.h"
#include "programs/outputs.h"
#include "programs/view_options.h"

#include <algorithm>

namespace cbvh {
namespace {

/* What the command line says in words of its own, with the defaults that --help names. */
struct Words
{
  std::vector<std::string> files;
  std::string representations = wordOf(RepresentationKind::CVert), size = "1024x1024", crop;
  std::string colors = "neutral", shutter = "0,1";
  LevelOptions levels;
  bool compare = false;
  std::optional<size_t> trueHits; // none: not said
};

/* The options, in the order of --help. */

void declarePictures(CLI::App& app, Options& o, Words& words)
{
  addFileArguments(app, words.files, true);
  app.add_option("--scene", o.scene.scene, "instead of files, a generated scene: " + listOfScenes())->type_name("NAME");
  addMeshOption(app, o.scene);
  addSceneOptions(app, o.scene);
  CLI::Option* const list =
    app.add_option("--representation", words.representations,
                   "comma list of " + listOfRepresentations(", ") + "; a frame level of its own after ^ or :. More than one are "
                   "compared: errors are measured against grid and naive, where those are among them")
      ->type_name("LIST")->capture_default_str();
  app.add_flag("--compare", words.compare, "compares " + defaultRepresentations() + "; of --mesh grid,cvert")->excludes(list);
  addViewLevelOptions(app, words.levels);
  app.add_option("--view", o.view, "full, close, or ex,ey,ez,lx,ly,lz,fov")->type_name("VIEW")->capture_default_str();
  app.add_option("--size", words.size, "picture size")->type_name("WxH")->capture_default_str();
  app.add_option("--crop", words.crop,
                 "render this part of the picture alone, in pixels from the upper left, without column x1 and row y1: what is joined of parts "
                 "is the whole picture. Files of --exr have it as their data window, a PNG is only as large as the part")
    ->type_name("x0,y0,x1,y1");
  app.add_option("--samples", o.samples, "samples a pixel of shaded pictures; maps of errors and all figures have one")
    ->type_name("N")->check(CLI::Range(1, 4096))->capture_default_str();
  addShutterOption(app, words.shutter);
  app.add_option("--colors", words.colors,
                 "neutral: grey from both sides; sides: magenta where the normal points away from the camera, which is a "
                 "flipped normal, or the inside of the surface")
    ->type_name("COLORS")->check(CLI::IsMember({"neutral", "sides"}))->capture_default_str();
  app.add_option("--output", o.output, "folder for the pictures, made if need be")
    ->type_name("DIR")->capture_default_str();
  app.add_option("--export", o.exportPath, "write the surface there, too, as cvert stores it, OBJ: quads that --mesh reads")->type_name("FILE");
  app.add_option("--save", o.savePath, "write the compressed scene there, too, which --load opens at once; a herd goes there copy by copy, and what was stopped goes on where it was; named .cbvh, programs take it like a cage")->type_name("FILE");
  app.add_option("--load", o.loadPath, "instead of files and scenes, what --save wrote, as it was compressed, whatever its name")->type_name("FILE");
  app.add_flag("--exr", o.exr, "write linear colours and the hits there, too, OpenEXR: position, distance, normal, u, v and primID");
}

void declareMeasurement(CLI::App& app, Options& o, Words& words)
{
  app.add_flag("--speed", o.speed, "measure how many rays a second each representation traces; of GRID's, where that is among them");
  app.add_option("--rays", o.rays, "rays in a speed measurement, 0 for one a pixel")
    ->type_name("N")->capture_default_str();
  app.add_option("--repeat", o.repeat, "speed measurements, of which the median counts")
    ->type_name("N")->capture_default_str();
  app.add_option("--ray-offset", o.rayOffset,
                 "distance of bounced rays' origins from the surface, in bounding-box diagonals")
    ->type_name("D")->capture_default_str();
  app.add_option("--ambient", o.ambientRays,
                 "pictures of ambient occlusion with so many rays a pixel, from each representation's own hits, "
                 "beside GRID's")
    ->type_name("N")->check(CLI::Range(0, 4096));
  app.add_option("--true-surface", words.trueHits,
                 "hits compared with the displaced limit surface itself, drawn at random, 0 for none [20000 where several "
                 "representations are compared]")
    ->type_name("N");
  app.add_option("--threads", o.build.threads, "threads for building and rendering, 0 for all")
    ->type_name("N")->capture_default_str();
  addDeviceOption(app, o.build.device);
  app.add_option("--isa", o.build.isa, "widest instruction set: sse2, sse4.2, avx, avx2 or avx512")->type_name("ISA");
  app.add_flag("--details", o.details, "all rows of the table");
  app.add_option("--json", o.json, "write all numbers there, too")->type_name("FILE");
}

/* What is compared has one level, unless auto is asked for: it is the same whatever the view. */
void chooseLevel(const CLI::App& app, const Words& words, Options& o)
{
  const bool isGiven = app.count("--level") != 0;
  const bool hasNaive = std::any_of(o.representations.begin(), o.representations.end(), [](const Representation& r) { return r.kind == RepresentationKind::Naive; });
  if (o.autoLevel && isGiven && hasNaive)
    throw Error("--level auto has no naive, whose triangles have one level for all edges");
  if (!isGiven && (o.compares() || hasNaive || o.speed))
    o.autoLevel = false;
  if (!o.scene.meshPath.empty())
    o.autoLevel = false;
  if (!o.autoLevel && app.count("--quad-size"))
    throw Error("--quad-size belongs to --level auto");
  o.quadSize = words.levels.quadSize;
  o.maxPixelError = words.levels.maxPixelError.value_or(o.autoLevel ? autoPixelError : 0.0f);
}

void read(const CLI::App& app, const Words& words, Options& o)
{
  if (o.loadPath.empty())
  {
    applyFileArguments(words.files, o.scene);
    o.loadPath = o.scene.savedPath;
  }
  else if (!(words.files.empty() && o.scene.scene.empty() && o.scene.cagePath.empty() && o.scene.meshPath.empty()))
    throw Error("--load is in place of files, --scene, --cage and --mesh");
  if (!o.loadPath.empty() && (!o.savePath.empty() || !o.exportPath.empty() || o.ambientRays || words.trueHits.value_or(0) || o.build.device != "cpu"))
    throw Error(o.loadPath + ": a file is traced on the processor, and has no model: --save, --export, --ambient, --true-surface and --device belong to models");
  if (o.savesCopyByCopy() && (!o.exportPath.empty() || o.ambientRays || words.trueHits.value_or(0) || o.build.device != "cpu"))
    throw Error("--save of a herd builds it copy by copy into the file, and makes a picture of that on the processor: --export, --ambient, --true-surface and --device belong to scenes in memory");
  if (o.loadPath.empty())
    validateScene(o.scene);
  else
    rejectModelOptions(app, o.loadPath);
  o.autoLevel = parseLevel(words.levels, o.build.level);
  validateBuild(o.build);
  if (o.repeat < 1)
    throw Error("--repeat must be at least 1");
  requireNotNegative("--ray-offset", o.rayOffset);
  o.scene.threads = o.build.threads;
  o.colors = words.colors == "sides" ? HitColors::Sides : HitColors::Neutral;
  o.size = parseImageSize(words.size);
  o.crop = parseCrop(words.crop, o.size);
  o.shutter = parseShutter(words.shutter);
  const bool isMesh = !o.scene.meshPath.empty();
  const std::string compared = isMesh ? wordOf(RepresentationKind::Grid) + "," + wordOf(RepresentationKind::CVert) : defaultRepresentations();
  o.representations = parseRepresentationOptions(words.compare ? compared : words.representations, words.levels.frameLevel);
  chooseLevel(app, words, o);
  o.trueHits = words.trueHits.value_or(o.compares() && !isMesh ? 20000 : 0);
  if (isMesh && o.trueHits)
    throw Error("--true-surface belongs to cages: a mesh is its own surface");
  const bool hasVert = std::any_of(o.representations.begin(), o.representations.end(), [](const Representation& r) { return r.kind == RepresentationKind::CVert; });
  if (!o.exportPath.empty() && !hasVert)
    throw Error("--export writes what cvert stores, which is not among the representations");
  if (!words.crop.empty() && (o.compares() || o.speed || o.ambientRays || words.trueHits.value_or(0)))
    throw Error("--crop is for parts of one picture: what is compared or measured, and --ambient, are of whole ones");
  if (!o.savePath.empty() && (o.compares() || !o.representations[0].isCompressed()))
    throw Error("--save takes one representation, which is neither grid nor naive");
  if (o.view != "full" && o.view != "close")
    parseView(o.view, {0, 1, 0}, o.size);
  SceneSettings inputs = o.scene;
  inputs.savedPath = o.loadPath;
  validateOutputs(inputs, {{"--save", o.savePath}, {"--export", o.exportPath}, {"--json", o.json}});
}

} // namespace

std::optional<Options> parseOptions(int argc, char** argv)
{
  Options o;
  Words words;
  CLI::App app("Makes a picture of a displaced subdivision surface, in cVERT unless told otherwise.\n"
               "Of several representations it makes one each, and compares them in memory, build, error and speed.",
               "cbvh_render");
  declarePictures(app, o, words);
  declareMeasurement(app, o, words);
  if (!parseCommandLine(app, argc, argv))
    return std::nullopt;
  read(app, words, o);
  return o;
}

} // namespace cbvh
