// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "saved_scene_picture.h"
#include "picture_files.h"
#include "speed.h"

#include "basics/error.h"
#include "basics/file_output.h"
#include "basics/parallel.h"
#include "basics/progress.h"
#include "building/saved_scene.h"
#include "building/scene_file_builder.h"
#include "pictures/sampled_picture.h"
#include "programs/json_text.h"
#include "programs/view_options.h"
#include "programs/warnings.h"
#include "tracing/camera.h"
#include "tracing/ray_conversion.h"
#include "tracing/ray_sets.h"
#include "tracing/trace_hits.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace programs {
namespace {

/* Time of a ray through the middle of the picture, including initialization for a thread's first ray unless a close
 * view was fitted by tracing. */
double firstRaySeconds(const SavedScene& scene, const Camera& camera) {
  RTCRayHit ray;
  load(primaryRay(camera, camera.size().width / 2, camera.size().height / 2), ray);
  const auto start = std::chrono::steady_clock::now();
  EmbreeTracer(scene.handle()).intersect(&ray, 1);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/* Single rays on one thread. The first round also loads the pages that only bounced rays reach. */
Speeds measureSpeed(const Options& options, const std::string& name, const SavedScene& scene,
                    const std::vector<Ray>& primary, const std::vector<SurfaceHit>& hits) {
  RaySets sets;
  makeRaySets(options, scene, primary, hits, sets);
  const Speeds speeds = InterleavedSpeed(sets, options.repeat).measure(name, scene, nullptr);
  scene.check();
  double difference = 0;
  for (const auto& ofSet : speeds)
    for (const Speed& speed : ofSet) difference = std::max(difference, speed.difference);
  const std::string note =
      difference > mostRoundDifference ? "; rounds differ by up to " + std::to_string(int(100 * difference)) + "%" : "";
  char line[320];
  std::snprintf(line, sizeof(line),
                "speed: one thread, single rays: %.2f million coherent rays per second and %.2f million incoherent "
                "ones; any hit %.2f and %.2f%s\n",
                speeds[Coherent][Closest].mrays, speeds[Incoherent][Closest].mrays, speeds[Coherent][Any].mrays,
                speeds[Incoherent][Any].mrays, note.c_str());
  writeStandardOutput(line);
  return speeds;
}

/* `fixed` is null to fit a camera to the scene. */
void render(const Options& options, const std::string& file, const std::string& name, const Camera* fixed, Vec3f up,
            nlohmann::json json) {
  const unsigned threads = threadCount(options.build.threads);
  const SavedScene scene(file, threads, options.build.isa);
  const Model box = fixed ? Model() : boxModel(name, scene.bounds(), options.scene.up);
  const Camera camera = fixed ? *fixed : chooseCamera(options.view, box, scene, options.size, threads);
  const double firstRay = firstRaySeconds(scene, camera);

  SampledPicture picture(camera, options.crop, fixed ? up : box.view.up, options.colors);
  std::vector<Ray> firstRays;
  std::vector<SurfaceHit> firstHits;
  double pictureSeconds = 0;
  {
    Phase phase(name + ": picture");
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < options.samples; i++) {
      std::vector<Ray> rays = primaryRays(camera, options.crop, sampleOffset(i));
      setTimes(rays, options.shutter, i, options.crop, options.size.width);
      std::vector<SurfaceHit> hits = traceClosest(scene, rays, threads);
      picture.add(rays, hits, threads);
      if (i == 0 && (options.exr || options.speed)) {
        firstRays = std::move(rays);
        firstHits = std::move(hits);
      }
      phase.update(double(i + 1) / options.samples);
    }
    pictureSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  scene.check();
  PictureFiles files(options.output, name, options.size, options.crop, options.colors, options.samples);
  const Representation representation{RepresentationKind(scene.geometries()[0].representation)};
  const std::string path = files.writePicture(representation, picture.image());
  if (options.exr) files.writeExr(representation, picture.linear(), firstRays, firstHits);
  char line[256];
  std::snprintf(line, sizeof(line),
                "%zu geometr%s, %.2f million quads, %.1f MiB; opened in %.1f ms, first ray after %.1f ms, rendered in "
                "%.2f s; %.1f MiB are not mapped\n",
                scene.geometries().size(), scene.geometries().size() == 1 ? "y" : "ies", double(scene.quads()) * 1e-6,
                double(scene.bytes()) / (1 << 20), 1e3 * scene.seconds(), 1e3 * (scene.seconds() + firstRay),
                pictureSeconds, double(scene.liveBytes()) / (1 << 20));
  writeStandardOutput(path + "\n" + file + ": " + line);
  if (options.speed) json["speed"] = speedJson(measureSpeed(options, name, scene, firstRays, firstHits));
  if (options.json.empty()) return;
  json.update({{"file", file},
               {"geometries", scene.geometries().size()},
               {"quads", scene.quads()},
               {"bytes", scene.bytes()},
               {"open_seconds", scene.seconds()},
               {"open_processor_seconds", scene.processorSeconds()},
               {"first_ray_seconds", scene.seconds() + firstRay},
               {"picture_seconds", pictureSeconds},
               {"live_bytes", scene.liveBytes()}});
  writeTextFile(options.json, textOfJson(json, 2));
}

} // namespace

void renderSavedScene(const Options& options) {
  const std::string name = std::filesystem::path(options.loadPath).stem().string();
  render(options, options.loadPath, name, nullptr, {}, nlohmann::json::object());
}

void saveAndRender(const Options& options, const ModelView& view) {
  const FileBuildReport built = buildToFile(view.model, options.representations[0], view.build, options.savePath);
  printWarnings("cbvh_render", seamWarnings(view.model, built.seams));
  char line[256];
  std::snprintf(line, sizeof(line),
                "%zu geometries, %zu of them from an interrupted build; the others, %.1f million quads, took %.1f s, "
                "%.2f million per second, with a peak of %.1f MiB\n",
                built.geometries, built.found, double(built.quads) * 1e-6, built.seconds,
                double(built.quads) * 1e-6 / built.seconds, double(built.peakBytes) / (1 << 20));
  writeStandardOutput(options.savePath + ": " + line);
  render(options, options.savePath, view.model.name, &view.camera, view.model.view.up,
         {{"resumed_geometries", built.found},
          {"build_seconds", built.seconds},
          {"built_quads", built.quads},
          {"build_peak_bytes", built.peakBytes},
          {"seam_gap", built.seams.distance},
          {"seam_gap_quads", built.seams.quads}});
}

} // namespace programs
