// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"
#include "path_tracer.h"
#include "picture_file.h"
#include "window.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "basics/progress.h"
#include "building/view_dicing.h"
#include "building/vulkan_tracer.h"
#include "programs/run_program.h"
#include "programs/program_scene.h"
#include "programs/view_options.h"

#include <chrono>
#include <cstdio>

namespace programs { namespace {

/* Views are fitted to GRID; a coarse one is sufficient. */
Camera findCamera(const PathTracerOptions& options, const Model& model) {
  constexpr int coarse = 3;
  BuildSettings settings = options.build;
  settings.level = std::min(settings.level, coarse);
  const BuiltScene grid(model, {RepresentationKind::Grid}, settings);
  return chooseCamera(options.view, model, grid, options.size, threadCount(options.build.threads));
}

BuildSettings settingsFor(const PathTracerOptions& options, const Model& model, const Camera& camera) {
  std::optional<ViewDicing> dicing;
  if (options.autoLevel) dicing = ViewDicing{options.quadSize, highestRate({options.representation})};
  return settingsForView(options.build, model, camera, dicing, options.maxPixelError);
}

std::unique_ptr<PathTracer> makePathTracer(const PathTracerOptions& options, const BuiltScene& scene,
                                           const PathView& view) {
  if (options.onCpu()) return makeCpuPathTracer(scene.handle(), view, threadCount(options.build.threads));
  Phase phase("upload of scene and shader to the device");
  const VulkanDeviceName name(options.device);
  return makeVulkanPathTracer(scene.handle(), view, name.selector, name.byRayQuery);
}

double secondsNow() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/* Drivers may compile the shader with the first sample. */
void traceSamples(PathTracer& tracer, const PathTracerOptions& options) {
  Phase phase("picture");
  const double start = secondsNow();
  double first = 0;
  while (tracer.samples() < options.samples) {
    throwIfCanceled();
    tracer.addSample();
    if (tracer.samples() == 1) first = secondsNow() - start;
    phase.update(double(tracer.samples()) / double(options.samples));
  }
  const double others = secondsNow() - start - first;
  std::printf("%s\n%u sample%s of %d x %d pixels: the first in %.2f s", tracer.deviceName().c_str(), options.samples,
              options.samples == 1 ? "" : "s", options.size.width, options.size.height, first);
  if (options.samples > 1)
    std::printf(", the others in %.2f s, %.3f million paths per second", others,
                1e-6 * double(options.samples - 1) * options.size.width * options.size.height / others);
  std::printf("\n");
}

int run(int argc, char** argv) {
  const std::optional<PathTracerOptions> options = parsePathTracerOptions(argc, argv);
  if (!options) return 0;
  if (options->window) requireWindows();
  installCancelHandler();
  const Model model = loadProgramScene("cbvh_pathtracer", options->scene);
  printWarnings("cbvh_pathtracer", motionWarnings(model, {options->representation}));
  const Camera camera = findCamera(*options, model);
  const BuiltScene scene(model, options->representation, settingsFor(*options, model, camera));
  printWarnings("cbvh_pathtracer", seamWarnings(model, scene.report().seams));
  const std::unique_ptr<PathTracer> tracer =
      makePathTracer(*options, scene, makePathView(camera, model.view.up, options->bounces, options->shutter));
  if (options->window) showWindow(*tracer, options->size, options->samples);
  else traceSamples(*tracer, *options);
  if (!options->output.empty() && tracer->samples() > 0)
    writePicture(options->output, options->size, tracer->picture());
  return 0;
}

}} // namespace programs

int main(int argc, char** argv) {
  return programs::runProgram("cbvh_pathtracer", [=] { return programs::run(argc, argv); });
}
