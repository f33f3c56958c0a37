// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/error.h"
#include "basics/text.h"
#include "scenes/catalogue.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <system_error>
#include <vector>

namespace programs {

/* Parses "3" or "3x2". Throws Error. */
inline Vec2f parseRepeat(const std::string& text) {
  Vec2f repeat;
  const char* const end = text.data() + text.size();
  const auto x = std::from_chars(text.data(), end, repeat.x);
  auto last = x;
  repeat.y = repeat.x;
  if (x.ec == std::errc() && x.ptr != end && *x.ptr == 'x') last = std::from_chars(x.ptr + 1, end, repeat.y);
  const auto isPositive = [](float r) { return std::isfinite(r) && r > 0.0f; };
  if (last.ec != std::errc() || last.ptr != end || !isPositive(repeat.x) || !isPositive(repeat.y))
    throw Error("invalid --height-repeat '" + text + "': expected one or two positive numbers, as in 3 or 3x2");
  return repeat;
}

/* Requires one of textureWrapNames(). */
inline TextureWrap parseWrap(const std::string& name) {
  const std::vector<std::string>& names = textureWrapNames();
  return TextureWrap(std::find(names.begin(), names.end(), name) - names.begin());
}

inline void addMapOptions(CLI::App& app, SceneSettings& settings) {
  app.add_option("--height", settings.heightPath,
                 "height map of the cage, any image that OpenImageIO reads; unsigned integers become 0 to 1, signed "
                 "integers -1 to 1; skin.<UDIM>.png for one file per UDIM tile")
      ->type_name("FILE");
  app.add_option("--amplitude", settings.amplitude,
                 "displacement between heights 0 and 1, as a fraction of the diagonal of the cage's bounding box [" +
                     shortNumber(defaultAmplitude) + "]")
      ->type_name("A");
  app.add_option("--height-scale", settings.mapScale,
                 "displacement between heights 0 and 1 in units of the cage, instead of --amplitude [1 for vectors]")
      ->type_name("S");
  app.add_option("--mid-level", settings.midLevel,
                 "height that moves nothing [" + shortNumber(neutralHeight) + "; 0 for vectors]")
      ->type_name("H");
  app.add_option("--channel", settings.channel,
                 "channel of the map, by name or number from 0; for vectors, the first of three channels [0]")
      ->type_name("C");
  app.add_option_function<std::string>(
         "--height-repeat", [&settings](const std::string& text) { settings.repeat = parseRepeat(text); },
         "copies of the map per unit of texture coordinates, or per face; N, or columns x rows [1]")
      ->type_name("N|NxM");
  app.add_option_function<std::string>(
         "--height-wrap", [&settings](const std::string& name) { settings.wrap = parseWrap(name); },
         "heights outside of the image: of the nearest texel (clamp), of copies of the image (repeat), or 0 (black) "
         "[repeat; clamp for UDIM tiles, and per face]")
      ->type_name("WRAP")
      ->check(CLI::IsMember(textureWrapNames()));
  app.add_option_function<std::string>(
         "--vectors",
         [&settings](const std::string& axes) {
           settings.mapValues = axes == "object" ? MapValues::ObjectVectors : MapValues::TangentVectors;
         },
         "the map contains vectors: along x, y and z of the cage (object), or along u of the texture, the normal, and "
         "v "
         "of the texture (tangent)")
      ->type_name("AXES")
      ->check(CLI::IsMember({"object", "tangent"}));
}

/* Adds arguments for applyFileArguments. `saved` is true if the program also shows files of compressed surfaces, and
 * `meshes` if it shows meshes. */
inline void addFileArguments(CLI::App& app, std::vector<std::string>& files, bool saved = false, bool meshes = true) {
  app.add_option("files", files,
                 std::string("a control cage (OBJ) and a height map, as for --cage and --height") +
                     (meshes ? "; or a mesh (PLY, STL, glTF or GLB), as for --mesh" : "") +
                     (saved ? "; or compressed surfaces (.cbvh), as cbvh_render --save writes them" : ""))
      ->type_name("FILE");
}

/* Throws Error if a model option accompanies the file of compressed surfaces at `path`. */
inline void rejectModelOptions(const CLI::App& app, const std::string& path) {
  for (const char* name :
       {"--representation", "--level",     "--quad-size",    "--max-pixel-error", "--frame-level", "--device",
        "--height",         "--amplitude", "--height-scale", "--mid-level",       "--channel",     "--height-repeat",
        "--height-wrap",    "--vectors",   "--compare",      "--details",         "--rough",       "--mapping",
        "--count",          "--cage-end",  "--motion",       "--steps",           "--map-folder"}) {
    const CLI::Option* const option = app.get_option_no_throw(name);
    if (option && option->count())
      throw Error(path + ": this file has no model for " + name + ": expected no model options");
  }
}

inline void addMeshOption(CLI::App& app, SceneSettings& settings) {
  app.add_option(
         "--mesh", settings.meshPath,
         "instead of a scene: mesh (OBJ, PLY, STL, glTF or GLB) that is traced without subdivision, as sculpting "
         "programs and\n--export of cbvh_render write it; grid means Embree's own quads or triangles, cvert "
         "compresses them; faces of more than 4 corners become triangles")
      ->type_name("FILE");
}

/* The value is for parseShutter. */
inline void addShutterOption(CLI::App& app, std::string& shutter) {
  app.add_option("--shutter", shutter,
                 "times at which the shutter opens and closes, for models that move: 0 is the first time step, 1 the "
                 "last")
      ->type_name("T0,T1")
      ->capture_default_str();
}

inline void addSceneOptions(CLI::App& app, SceneSettings& settings) {
  app.add_option("--cage", settings.cagePath, "instead of a scene: control cage (OBJ), with OpenSubdiv's t tags")
      ->type_name("FILE");
  app.add_option("--up", settings.up,
                 "up axis of the cage: x, y, z, -x, -y, -z, or auto, which is y unless\n"
                 "the file or the shape is clearly z up [auto]")
      ->type_name("AXIS")
      ->check(CLI::IsMember({"auto", "x", "y", "z", "-x", "-y", "-z"}));
  addMapOptions(app, settings);
  app.add_flag("--rough", settings.rough, "trex and herd: multiply the amplitude by five");
  app.add_option("--mapping", settings.mapping, "trex and herd: heights on faces, as in Ptex, or in an atlas [faces]")
      ->type_name("faces|atlas");
  app.add_option("--count", settings.count, "herd: number of copies")->type_name("N");
  app.add_option("--cage-end", settings.cageEnds,
                 "the cage at the end of the shutter, an OBJ with the same faces; several files: further time steps at "
                 "equal intervals, in order")
      ->type_name("FILE");
  app.add_option("--motion", settings.motion,
                 "instead of --cage-end: turn, bend, twist or walk while the shutter is open")
      ->type_name("NAME");
  app.add_option("--steps", settings.steps, "number of time steps of --motion, 2 to 129 [2]")->type_name("N");
  app.add_option("--map-folder", settings.mapFolder,
                 "folder for height maps of generated scenes [the user's cache folder]")
      ->type_name("DIR");
}

} // namespace programs
