// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"
#include "error.h"

#include <CLI/CLI.hpp>

#include <charconv>
#include <cstdio>
#include <set>

namespace cbvh {
namespace {

ImageSize parseSize(const std::string& text)
{
  ImageSize size;
  const char* const end = text.data() + text.size();
  const auto w = std::from_chars(text.data(), end, size.width);
  if (w.ec == std::errc() && w.ptr != end && *w.ptr == 'x')
  {
    const auto h = std::from_chars(w.ptr + 1, end, size.height);
    if (h.ec == std::errc() && h.ptr == end && size.width > 0 && size.height > 0 && size.width <= 16384 &&
        size.height <= 16384)
      return size;
  }
  throw Error("--size '" + text + "' is not WIDTHxHEIGHT with 1 to 16384 pixels each");
}

} // namespace

Camera parseView(const std::string& text, Vec3f up, ImageSize size)
{
  float x[7];
  int n = 0;
  const char* p = text.data();
  const char* const end = p + text.size();
  for (; n < 7; n++)
  {
    const auto [next, code] = std::from_chars(p, end, x[n]);
    if (code != std::errc() || !std::isfinite(x[n]) || (n < 6 ? next == end || *next != ',' : next != end))
      break;
    p = next + 1;
  }
  if (n < 7 || !(x[6] > 0.0f && x[6] < 180.0f) || length(Vec3f{x[3] - x[0], x[4] - x[1], x[5] - x[2]}) == 0.0f)
    throw Error("--view '" + text + "' is neither full nor close nor eye and target as ex,ey,ez,lx,ly,lz,fov");
  return Camera({x[0], x[1], x[2]}, {x[3], x[4], x[5]}, up, x[6], size);
}

std::optional<Options> parseOptions(int argc, char** argv)
{
  Options o;
  std::string representations = "naive,grid,cgrid,cvoxel,cleaf", frameLevel = "2", size = "1024x1024";
  bool noSpeed = false;

  CLI::App app("Builds a displaced subdivision surface in several representations, traces it, and compares them.\n"
               "Writes for each a shaded picture, the hits as EXR, and the error against GRID as a heat map.",
               "cbvh_render");
  app.add_option("--scene", o.scene, "generated scene: cube or trex")->type_name("NAME");
  app.add_option("--cage", o.cagePath, "control cage, OBJ with OpenSubdiv's t tags")->type_name("FILE");
  app.add_option("--height", o.heightPath, "height map of the cage, any image that OpenImageIO reads")->type_name("FILE");
  app.add_option("--amplitude", o.amplitude,
                 "displacement between heights 0 and 1, as a fraction of the diagonal of the cage's bounding box")
    ->type_name("A");
  app.add_flag("--rough", o.rough, "trex: five times the amplitude");
  app.add_option("--representation", representations,
                 "comma list of naive, grid, cgrid, cvoxel, cleaf; a frame level of its own after ^ or :")
    ->type_name("LIST")->capture_default_str();
  app.add_option("--level", o.build.level, "subdivision level, 0 to 8: 2^L x 2^L quads a face")
    ->type_name("L")->capture_default_str();
  app.add_option("--frame-level", frameLevel, "level at which local frames start: 0 to 8, or auto")
    ->type_name("N")->capture_default_str();
  app.add_option("--view", o.view, "full, close, or ex,ey,ez,lx,ly,lz,fov")->type_name("VIEW")->capture_default_str();
  app.add_option("--size", size, "picture size")->type_name("WxH")->capture_default_str();
  app.add_option("--output", o.output, "folder for the pictures, made if need be")->type_name("DIR")->capture_default_str();
  app.add_option("--rays", o.rays, "rays in a speed measurement, 0 for one a pixel")->type_name("N")->capture_default_str();
  app.add_option("--repeat", o.repeat, "speed measurements, of which the median counts")->type_name("N")->capture_default_str();
  app.add_option("--ray-offset", o.rayOffset,
                 "distance of bounced rays' origins from the surface, in bounding-box diagonals")
    ->type_name("D")->capture_default_str();
  app.add_option("--threads", o.build.threads, "threads for building and rendering, 0 for all")->type_name("N")->capture_default_str();
  app.add_option("--isa", o.build.isa, "widest instruction set: sse2, sse4.2, avx, avx2 or avx512")->type_name("ISA");
  app.add_option("--json", o.json, "write the numbers there, too")->type_name("FILE");
  app.add_flag("--no-speed", noSpeed, "leave the speed measurements out");
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::CallForHelp&)
  {
    std::fputs(app.help().c_str(), stdout);
    return std::nullopt;
  }
  catch (const CLI::ParseError& e)
  {
    throw Error(e.what());
  }

  if (o.scene.empty() == o.cagePath.empty())
    throw Error("give either --scene cube|trex or --cage FILE");
  if (!o.scene.empty() && o.scene != "cube" && o.scene != "trex")
    throw Error("unknown --scene '" + o.scene + "', known are cube and trex");
  if (!o.scene.empty() && !o.heightPath.empty())
    throw Error("--height belongs to --cage, generated scenes bring their own displacement");
  if (o.rough && o.scene != "trex")
    throw Error("--rough belongs to --scene trex");
  if (o.amplitude && !o.cagePath.empty() && o.heightPath.empty())
    throw Error("--amplitude needs a height map, give --height FILE");
  if (o.amplitude && !std::isfinite(*o.amplitude))
    throw Error("--amplitude must be finite");
  if (o.build.level < 0 || o.build.level > maxLevel)
    throw Error("--level " + std::to_string(o.build.level) + " is out of range, 0 to " + std::to_string(maxLevel));
  if (o.build.threads < 0)
    throw Error("--threads must not be negative");
  if (o.repeat < 1)
    throw Error("--repeat must be at least 1");
  if (!(o.rayOffset >= 0.0f) || !std::isfinite(o.rayOffset))
    throw Error("--ray-offset must be finite and not negative");
  if (!std::set<std::string>{"", "sse2", "sse4.2", "avx", "avx2", "avx512"}.count(o.build.isa))
    throw Error("unknown --isa '" + o.build.isa + "', known are sse2, sse4.2, avx, avx2 and avx512");
  o.speed = !noSpeed;
  o.size = parseSize(size);
  try
  {
    o.representations = parseRepresentations(representations, parseFrameLevel(frameLevel));
  }
  catch (const Error& e)
  {
    throw Error(std::string("--representation or --frame-level: ") + e.what());
  }
  if (o.view != "full" && o.view != "close")
    parseView(o.view, {0, 1, 0}, o.size);
  return o;
}

} // namespace cbvh
