// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"
#include "basics/error.h"
#include "basics/image_file.h"
#include "programs/command_line.h"
#include "programs/opened_files.h"
#include "programs/outputs.h"
#include "programs/view_options.h"

#include <unistd.h>

namespace programs {
namespace {

std::string listOfModes() {
  std::string list;
  for (PictureMode mode : allPictureModes) list += (list.empty() ? "" : ", ") + std::string(pictureModeName(mode));
  return list;
}

/* Reports misspelled names on the command line instead of in the window. Opening a FIFO would block. */
void requireFile(const std::string& path) {
  if (!path.empty() && access(path.c_str(), R_OK) != 0)
    throw Error(path + ": cannot be opened: expected a readable file");
}

} // namespace

std::optional<ViewerOptions> parseViewerOptions(int argc, char** argv) {
  ViewerOptions o;
  std::vector<std::string> files;
  std::string representations = optionNameOf(preferredKind), size = "1024x768", mode = "shading";

  CLI::App app("Shows a displaced subdivision surface in one representation, or in two side by side. Opens a window,\n"
               "which lists its keys and opens files that are dropped onto it, or writes a picture with --no-window.",
               "cbvh_viewer");
  addFileArguments(app, files, true);
  app.add_option("--scene", o.scene.scene, "generated scene, " + listOfScenes())->type_name("NAME");
  addMeshOption(app, o.scene);
  addSceneOptions(app, o.scene);
  app.add_option("--representation", representations,
                 listOfRepresentations(", ", " or ") + "; a frame level may follow after ^ or :; "
                                                       "two names, separated by a comma, split the screen")
      ->type_name("LIST")
      ->capture_default_str();
  LevelOptions levels;
  addViewLevelOptions(app, levels);
  app.add_option("--show", mode, "contents of the picture: " + listOfModes())->type_name("MODE")->capture_default_str();
  app.add_option("--view", o.view, "full, close, or ex,ey,ez,lx,ly,lz,fov")->type_name("VIEW")->capture_default_str();
  app.add_option("--size", size, "size of window or picture")->type_name("WxH")->capture_default_str();
  app.add_option("--samples", o.samples,
                 "samples per pixel of shading, which the window adds while nothing moves; other contents and all\n"
                 "figures have one")
      ->type_name("N")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  app.add_option("--time", o.time,
                 "time of a model that moves: 0 is the first time step, 1 the last; the window has a slider")
      ->type_name("T")
      ->capture_default_str();
  app.add_flag("--no-window", o.noWindow, "write the picture to --output, and open no window");
  app.add_option("--output", o.output,
                 "file for the picture, which key P of the window saves; the extension selects the format")
      ->type_name("FILE")
      ->capture_default_str();
  app.add_option("--threads", o.build.threads, "threads for building and rendering, 0 for all")
      ->type_name("N")
      ->capture_default_str();
  addDeviceOption(app, o.build.device);
  addIsaOption(app, o.build.isa);
  if (!parseCommandLine(app, argc, argv)) return std::nullopt;

  applyFileArguments(files, o.scene);
  const bool empty =
      o.scene.scene.empty() && o.scene.cagePath.empty() && o.scene.meshPath.empty() && o.scene.heightPath.empty();
  if (!o.scene.savedPath.empty()) {
    rejectModelOptions(app, o.scene.savedPath);
    if (mode != "shading" && mode != "normals")
      throw Error("--show " + mode + " needs a model, but " + o.scene.savedPath +
                  " contains none: expected shading or normals");
  } else if (!empty || o.noWindow) // only a window may start empty
    validateScene(o.scene);
  requireFile(o.scene.cagePath);
  requireFile(o.scene.savedPath);
  o.autoLevel = parseLevel(levels, o.build.level);
  validateBuild(o.build);
  if (!o.autoLevel && levels.maxPixelError) throw Error("--max-pixel-error needs --level auto");
  if (!(o.time >= 0.0f && o.time <= 1.0f)) throw Error("invalid --time " + shortNumber(o.time) + ": expected 0 to 1");
  o.quadSize = levels.quadSize;
  o.maxPixelError = levels.maxPixelError.value_or(autoPixelError);
  o.scene.threads = o.build.threads;
  o.size = parseImageSize(size);
  bool known = false;
  for (PictureMode m : allPictureModes)
    if (mode == pictureModeName(m)) {
      o.mode = m;
      known = true;
    }
  if (!known) throw Error("unknown --show '" + mode + "': expected one of " + listOfModes());
  o.representations = parseRepresentationOptions(representations, levels.frameLevel);
  if (o.representations.size() > 2)
    throw Error("--representation '" + representations + "' names more than two: expected one or two");
  if (o.view != "full" && o.view != "close") parseView(o.view, {0, 1, 0}, o.size);
  validateOutputs(o.scene, {{"--output", o.output}});
  requireImageFormat(o.output);
  if (o.noWindow) requireWritable({{"--output", o.output}});
  else requireFolders({{"--output", o.output}});
  return o;
}

} // namespace programs
