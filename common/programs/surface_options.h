// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What surfaces are made of, as all programs take it on their command lines: cages, maps,
 * and what generated scenes have to choose. */

#include "basics/error.h"
#include "scenes/catalogue.h"

#include <CLI/CLI.hpp>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <string>
#include <system_error>
#include <vector>

namespace cbvh {

/* Reads "3" or "3x2". Throws Error. */
inline Vec2f parseRepeat(const std::string& text)
{
  Vec2f repeat;
  const char* const end = text.data() + text.size();
  const auto x = std::from_chars(text.data(), end, repeat.x);
  auto last = x;
  repeat.y = repeat.x;
  if (x.ec == std::errc() && x.ptr != end && *x.ptr == 'x')
    last = std::from_chars(x.ptr + 1, end, repeat.y);
  const auto isGood = [](float r) { return std::isfinite(r) && r > 0.0f; };
  if (last.ec != std::errc() || last.ptr != end || !isGood(repeat.x) || !isGood(repeat.y))
    throw Error("--height-repeat '" + text + "' is neither a positive number nor two of them, as in 3x2");
  return repeat;
}

/* For --help: as few digits as say it. */
inline std::string shortNumber(float value)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%g", double(value));
  return text;
}

/* The map of a cage, and how it is read. */
inline void addMapOptions(CLI::App& app, SceneSettings& settings)
{
  app.add_option("--height", settings.heightPath,
                 "height map of the cage, any image that OpenImageIO reads, integers as 0 to 1, "
                 "signed ones as -1 to 1; skin.<UDIM>.png for a file per UDIM tile")
    ->type_name("FILE");
  app.add_option("--amplitude", settings.amplitude,
                 "displacement between heights 0 and 1, as a fraction of the diagonal of the cage's bounding box [" +
                   shortNumber(defaultAmplitude) + "]")
    ->type_name("A");
  app.add_option("--height-scale", settings.mapScale, "the same in the units of the cage, in place of --amplitude; 1 for vectors")
    ->type_name("S");
  app.add_option("--mid-level", settings.midLevel, "height that moves nothing [" + shortNumber(neutralHeight) + "; 0 for vectors]")->type_name("H");
  app.add_option("--channel", settings.channel,
                 "channel of the map, by its name or its number from 0; the first of three for vectors [0]")
    ->type_name("C");
  app.add_option_function<std::string>(
       "--height-repeat", [&settings](const std::string& text) { settings.repeat = parseRepeat(text); },
       "copies of the map in a unit of texture coordinates, or on a face, also as columns x rows [1]")
    ->type_name("N|NxM");
  app.add_option_function<std::string>(
       "--vectors",
       [&settings](const std::string& axes) {
         settings.mapValues = axes == "object" ? MapValues::ObjectVectors : MapValues::TangentVectors;
       },
       "the map has vectors: x y z of the cage, or along the texture's u, the normal, and the texture's v")
    ->type_name("AXES")
    ->check(CLI::IsMember({"object", "tangent"}));
}

/* Files without an option before them, for nameFiles (opened_files.h).
 * saved: whether the program shows files of compressed surfaces, too. */
inline void addFiles(CLI::App& app, std::vector<std::string>& files, bool saved = false)
{
  app.add_option("files", files, std::string("a control cage (OBJ) and a height map, as with --cage and --height") +
                 (saved ? "; or compressed surfaces (.cbvh), as cbvh_render --save writes them" : ""))->type_name("FILE");
}

/* Throws Error for options that say how a model is made or built, beside a file of compressed surfaces. */
inline void refuseModelOptions(const CLI::App& app, const std::string& path)
{
  for (const char* name : {"--representation", "--level", "--quad-size", "--max-pixel-error", "--frame-level", "--device", "--height", "--amplitude",
                           "--height-scale", "--mid-level", "--channel", "--height-repeat", "--vectors", "--compare", "--details", "--rough", "--mapping", "--count",
                           "--cage-end", "--motion", "--steps", "--maps"})
  {
    const CLI::Option* const option = app.get_option_no_throw(name);
    if (option && option->count())
      throw Error(path + ": " + name + " belongs to models, and a file has none");
  }
}

/* A mesh in place of a scene. */
inline void addMeshOption(CLI::App& app, SceneSettings& settings)
{
  app.add_option("--mesh", settings.meshPath,
                 "instead of a scene: quads and triangles that are traced as they are, OBJ, as sculpting programs export them, and\n"
                 "--export of cbvh_render; grid is Embree's own kernel of quads or triangles then, cvert compresses them")
    ->type_name("FILE");
}

/* shutter: text for parseShutter. */
inline void addShutterOption(CLI::App& app, std::string& shutter)
{
  app.add_option("--shutter", shutter, "when the shutter opens and closes, of models that move: 0 is their first step, 1 the last")
    ->type_name("T0,T1")->capture_default_str();
}

/* What a model is made of, but for --scene. */
inline void addSceneOptions(CLI::App& app, SceneSettings& settings)
{
  app.add_option("--cage", settings.cagePath, "instead of a scene: control cage, OBJ with OpenSubdiv's t tags")
    ->type_name("FILE");
  app.add_option("--up", settings.up, "axis of the cage that points upwards: x, y, z, -x, -y, -z, or auto, which is y unless\n"
                 "the file or the shape is clearly z up [auto]")
    ->type_name("AXIS")->check(CLI::IsMember({"auto", "x", "y", "z", "-x", "-y", "-z"}));
  addMapOptions(app, settings);
  app.add_flag("--rough", settings.rough, "trex and herd: five times the amplitude");
  app.add_option("--mapping", settings.mapping, "trex and herd: heights by faces, like Ptex, or by an atlas")
    ->type_name("faces|atlas");
  app.add_option("--count", settings.count, "herd: number of copies")->type_name("N");
  app.add_option("--cage-end", settings.cageEnds, "the cage at the end of the shutter, OBJ with the same faces; several: at even times, one after the other")
    ->type_name("FILE");
  app.add_option("--motion", settings.motion, "in place of that: turn, bend, twist or walk, while the shutter is open")->type_name("NAME");
  app.add_option("--steps", settings.steps, "time steps of --motion, 2 to 129 [2]")->type_name("N");
  app.add_option("--maps", settings.mapFolder, "folder for the height maps of generated scenes, else the user's cache")
    ->type_name("DIR");
}

} // namespace cbvh
