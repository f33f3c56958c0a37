// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"
#include "basics/error.h"
#include "programs/command_line.h"
#include "programs/view_options.h"

namespace cbvh {
namespace {

/* What the command line says in words of its own, with the defaults that --help names. */
struct Words
{
  std::string representations = listOfRepresentations(","), frameLevel = "2", size = "1024x1024";
  std::string colors = "neutral";
  bool noSpeed = false;
};

/* The options, in the order of --help. */

void declarePictures(CLI::App& app, Options& o, Words& words)
{
  app.add_option("--scene", o.scene.scene, "generated scene: " + listOfScenes())->type_name("NAME");
  addSceneOptions(app, o.scene);
  app.add_option("--representation", words.representations,
                 "comma list of " + listOfRepresentations(", ") + "; a frame level of its own after ^ or :. Speeds are "
                 "relative to grid, and errors measured against grid and naive, where those are among them")
    ->type_name("LIST")->capture_default_str();
  addLevelOptions(app, o.build.level, words.frameLevel);
  app.add_option("--max-pixel-error", o.maxPixelError,
                 "spacing of cVERT's vertices in pixels of the view, at most; 0 for 1/36 of a quad's edge")
    ->type_name("P")->capture_default_str();
  app.add_option("--view", o.view, "full, close, or ex,ey,ez,lx,ly,lz,fov")->type_name("VIEW")->capture_default_str();
  app.add_option("--size", words.size, "picture size")->type_name("WxH")->capture_default_str();
  app.add_option("--colors", words.colors,
                 "neutral: grey from both sides; sides: magenta where the normal points away from the camera, which is a "
                 "flipped normal, or the inside of the surface")
    ->type_name("COLORS")->check(CLI::IsMember({"neutral", "sides"}))->capture_default_str();
  app.add_option("--output", o.output, "folder for the pictures, made if need be")
    ->type_name("DIR")->capture_default_str();
}

void declareMeasurement(CLI::App& app, Options& o, Words& words)
{
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
  app.add_option("--true-surface", o.trueHits,
                 "hits compared with the displaced limit surface itself, drawn at random, 0 for none")
    ->type_name("N")->capture_default_str();
  app.add_option("--threads", o.build.threads, "threads for building and rendering, 0 for all")
    ->type_name("N")->capture_default_str();
  addDeviceOption(app, o.build.device);
  app.add_option("--isa", o.build.isa, "widest instruction set: sse2, sse4.2, avx, avx2 or avx512")->type_name("ISA");
  app.add_flag("--details", o.details, "all rows of the table");
  app.add_option("--json", o.json, "write all numbers there, too")->type_name("FILE");
  app.add_flag("--no-speed", words.noSpeed, "leave the speed measurements out");
}

void read(const Words& words, Options& o)
{
  validateScene(o.scene);
  validateBuild(o.build);
  if (o.repeat < 1)
    throw Error("--repeat must be at least 1");
  requireNotNegative("--ray-offset", o.rayOffset);
  requireNotNegative("--max-pixel-error", o.maxPixelError);
  o.scene.threads = o.build.threads;
  o.speed = !words.noSpeed;
  o.colors = words.colors == "sides" ? HitColors::Sides : HitColors::Neutral;
  o.size = parseImageSize(words.size);
  o.representations = parseRepresentationOptions(words.representations, words.frameLevel);
  if (o.view != "full" && o.view != "close")
    parseView(o.view, {0, 1, 0}, o.size);
}

} // namespace

std::optional<Options> parseOptions(int argc, char** argv)
{
  Options o;
  Words words;
  CLI::App app("Builds a displaced subdivision surface in several representations, traces it, and compares them.\n"
               "Writes for each a shaded picture and the hits as EXR, and beside GRID or NAIVE a map of the errors.",
               "cbvh_render");
  declarePictures(app, o, words);
  declareMeasurement(app, o, words);
  if (!parseCommandLine(app, argc, argv))
    return std::nullopt;
  read(words, o);
  return o;
}

} // namespace cbvh
