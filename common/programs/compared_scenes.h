// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Options of the programs that measure two ways to store scenes side by side, and the models that these name. */

#include "programs/surface_options.h"
#include "scenes/catalogue.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <string>
#include <vector>

namespace cbvh {

struct ComparedScenes
{
  std::vector<std::string> scenes{"trex", "frog", "cube"};
  SceneSettings cage; // in their place, if it has a path
  int level = 6;
  unsigned repeat = 5;
  int side = 512;     // of the picture whose rays are traced
  std::string isa;

  /* cageOption: what names the cage, "--cage", or more than one with a comma between. */
  void addOptions(CLI::App& app, const std::string& cageOption)
  {
    app.add_option("--scene", scenes, "comma list of " + listOfScenes())->delimiter(',')->capture_default_str();
    app.add_option("--level", level, "of tessellation: faces have 2^L x 2^L quads")->capture_default_str();
    app.add_option("--repeat", repeat, "runs, of which the median is shown")->check(CLI::PositiveNumber)->capture_default_str();
    app.add_option("--size", side, "pixels along a side of the picture whose rays are traced")->check(CLI::PositiveNumber)->capture_default_str();
    app.add_option("--isa", isa, "widest instruction set, as Embree names it [the host's best]");
    addMapOptions(app, cage);
    app.add_option(cageOption, cage.cagePath, "a cage in place of scenes, OBJ")->type_name("FILE");
  }

  /* measure(model), of each; prints their warnings. Throws Error. */
  template<typename Measure>
  void forEach(const Measure& measure) const
  {
    for (const std::string& scene : cage.cagePath.empty() ? scenes : std::vector<std::string>{""})
    {
      SceneSettings of = cage;
      of.scene = scene;
      std::string warnings;
      Model model = loadScene(withStrength(of), warnings);
      std::fputs(warnings.c_str(), stderr);
      measure(model);
    }
  }

  std::string deviceConfig() const { return isa.empty() ? "" : "isa=" + isa; }
};

} // namespace cbvh
