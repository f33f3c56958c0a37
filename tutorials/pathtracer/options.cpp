// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"
#include "picture_file.h"
#include "building/vulkan_tracer.h"
#include "programs/command_line.h"
#include "programs/opened_files.h"
#include "programs/outputs.h"
#include "programs/view_options.h"

#include <embree3/rtcore_vulkan.h>

#include <algorithm>
#include <cstring>

namespace programs {
namespace {

/* The first GPU, otherwise the CPU. Skips Mesa's llvmpipe, which runs on the CPU. */
std::string chooseDevice() {
  RTCVulkanDeviceInfo infos[16];
  const unsigned count = std::min(rtcGetVulkanDevices(nullptr, infos, 16), 16u);
  for (unsigned i = 0; i < count; i++)
    if (!infos[i].unsupportedReason[0] && std::strncmp(infos[i].name, "llvmpipe", 8) != 0)
      return "vulkan:" + std::to_string(i);
  return "cpu";
}

} // namespace

std::optional<PathTracerOptions> parsePathTracerOptions(int argc, char** argv) {
  PathTracerOptions o;
  std::vector<std::string> files;
  std::string representation = optionNameOf(preferredKind);
  std::string size = "512x512", device = "auto", shutter = "0,1";

  CLI::App app("Renders a displaced subdivision surface by path tracing, entirely in a shader on a Vulkan device, or\n"
               "with the same random numbers on the CPU. Writes a picture, or shows it in a window sample by sample.",
               "cbvh_pathtracer");
  addFileArguments(app, files);
  app.add_option("--scene", o.scene.scene, "generated scene: " + listOfScenes())->type_name("NAME");
  addMeshOption(app, o.scene);
  addSceneOptions(app, o.scene);
  app.add_option("--representation", representation,
                 listOfRepresentations(", ", " or ") + "; a frame level may follow after ^ or :")
      ->type_name("NAME")
      ->capture_default_str();
  LevelOptions levels;
  addViewLevelOptions(app, levels);
  app.add_option("--view", o.view, "full, close, or ex,ey,ez,lx,ly,lz,fov")->type_name("VIEW")->capture_default_str();
  app.add_option("--size", size, "picture size")->type_name("WxH")->capture_default_str();
  app.add_option("--samples", o.samples, "paths per pixel")
      ->type_name("N")
      ->check(CLI::Range(1, 1 << 24))
      ->capture_default_str();
  app.add_option("--bounces", o.bounces, "number of hits of a path after the first")
      ->type_name("N")
      ->check(CLI::Range(0, 64))
      ->capture_default_str();
  addShutterOption(app, shutter);
  addDeviceOption(app, device, "auto for a GPU if there is one, else cpu; ");
  app.add_flag("--window", o.window, "show the picture during rendering");
  app.add_option("--output", o.output,
                 "file for the picture: linear as .exr, sRGB as .png [cbvh_pathtracer.png, or none with --window]")
      ->type_name("FILE");
  app.add_option("--threads", o.build.threads, "threads for building and for --device cpu, 0 for all")
      ->type_name("N")
      ->capture_default_str();
  addIsaOption(app, o.build.isa);
  if (!parseCommandLine(app, argc, argv)) return std::nullopt;

  applyFileArguments(files, o.scene);
  validateScene(o.scene);
  o.autoLevel = parseLevel(levels, o.build.level);
  validateBuild(o.build);
  o.scene.threads = o.build.threads;
  o.size = parseImageSize(size);
  o.shutter = parseShutter(shutter);
  o.device = device == "auto" ? chooseDevice() : device;
  validateTraceDevice(o.device);
  const std::vector<Representation> representations = parseRepresentationOptions(representation, levels.frameLevel);
  if (representations.size() != 1)
    throw Error("--representation '" + representation + "' names more than one: expected one");
  o.representation = representations[0];
  if (!o.scene.meshPath.empty() || (o.representation.isTriangulated() && app.count("--level") == 0))
    o.autoLevel = false; // unsupported for meshes and triangles
  if (o.autoLevel && o.representation.isTriangulated())
    throw Error("--level auto does not support " + optionNameOf(o.representation.kind) +
                ", which has one level for all edges: expected " + levelRange());
  o.quadSize = levels.quadSize;
  o.maxPixelError = levels.maxPixelError.value_or(o.autoLevel ? autoPixelError : 0.0f);
  if (o.view != "full" && o.view != "close") parseView(o.view, {0, 1, 0}, o.size);
  if (o.output.empty() && !o.window) o.output = "cbvh_pathtracer.png";
  if (!o.output.empty()) validatePicturePath(o.output);
  validateOutputs(o.scene, {{"--output", o.output}});
  return o;
}

} // namespace programs
