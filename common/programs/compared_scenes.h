// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Options of programs that compare two ways to store a scene. */

#include "building/built_scene.h"
#include "programs/command_line.h"
#include "programs/surface_options.h"
#include "programs/view_options.h"
#include "scenes/catalogue.h"
#include "tracing/image_size.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <string>
#include <vector>

namespace programs {

struct ComparedScenes {
  std::vector<std::string> scenes{"trex", "frog", "cube"};
  SceneSettings cage; // replaces the scenes if it has a path
  int level = 6;
  unsigned repeat = 5;
  ImageSize size{512, 512}; // of the picture
  std::string isa;

  void addOptions(CLI::App& app) {
    app.add_option("--scene", scenes, "comma-separated list of " + listOfScenes())
        ->type_name("LIST")
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--level", level, "tessellation level L: each face has 2^L x 2^L quads")
        ->type_name("L")
        ->capture_default_str();
    app.add_option("--repeat", repeat, "number of runs, whose median is reported")
        ->type_name("N")
        ->check(countRange(1))
        ->capture_default_str();
    app.add_option_function<std::string>(
           "--size", [this](const std::string& text) { size = parseImageSize(text); },
           "size of the picture whose rays are traced")
        ->type_name("WxH")
        ->default_str("512x512");
    addIsaOption(app, isa);
    addMapOptions(app, cage);
    app.add_option("--cage", cage.cagePath, "control cage (OBJ) instead of scenes")->type_name("FILE");
  }

  /* Throws Error. */
  void validate() const {
    BuildSettings settings;
    settings.level = level;
    settings.isa = isa;
    validateBuild(settings);
  }

  /* Prints warnings. Throws Error. */
  template<typename Measure>
  void forEach(const Measure& measure) const {
    for (const std::string& scene : cage.cagePath.empty() ? scenes : std::vector<std::string>{""}) {
      SceneSettings settings = cage;
      settings.scene = scene;
      std::string warnings;
      Model model = loadScene(withDefaultAmplitude(settings), warnings);
      std::fputs(warnings.c_str(), stderr);
      measure(model);
    }
  }

  std::string deviceConfig() const { return isa.empty() ? "" : "isa=" + isa; }
};

} // namespace programs
