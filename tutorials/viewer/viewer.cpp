// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "viewer.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "pictures/image_output.h"
#include "programs/opened_files.h"
#include "programs/view_options.h"
#include "programs/warnings.h"
#include "surface/up_axis.h"
#include "tracing/trace_hits.h"

#include <cstdio>
#include <filesystem>
#include <new>

namespace programs {
namespace {

std::string nameOf(const SceneSettings& source) {
  const std::string path = source.cagePath + source.meshPath + source.savedPath;
  return source.scene.empty() ? std::filesystem::path(path).filename().string() : source.scene;
}

bool sameCage(const SceneSettings& a, const SceneSettings& b) {
  return a.scene == b.scene && a.cagePath == b.cagePath && a.meshPath == b.meshPath && a.savedPath == b.savedPath;
}

bool sameScenes(const std::vector<Pane>& a, const std::vector<Pane>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Pane& x, const Pane& y) { return x.scene == y.scene && x.reference == y.reference; });
}

} // namespace

Viewer::Viewer(const ViewerOptions& options) : options(options), shownTime(options.time) {
  worker.reportProgress();
  requested.representations = options.representations;
  requested.level = options.autoLevel ? autoLevel : options.build.level;
  requested.mode = options.mode;
  shown = requested;
  const SceneSettings& scene = options.scene;
  if (!scene.scene.empty() || !scene.cagePath.empty() || !scene.meshPath.empty() || !scene.savedPath.empty())
    open(options.scene);
}

/* --- files ------------------------------------------------------------------------------- */

void Viewer::open(const SceneSettings& source) {
  toLoad = source;
  lastMessage.clear();
  if (loading) worker.cancel();
  if (document) document->store.request({});
}

void Viewer::openFiles(const std::vector<std::string>& paths) {
  try {
    open(programs::openFiles(paths, latestSource()));
  } catch (const Error& e) { lastMessage = e.what(); }
}

void Viewer::setStrength(float strength) {
  SceneSettings source = withDefaultAmplitude(latestSource());
  std::optional<float>& given = source.mapScale ? source.mapScale : source.amplitude;
  if (given && *given != strength) {
    given = strength;
    open(source);
  }
}

const SceneSettings& Viewer::latestSource() const {
  return toLoad ? *toLoad : loading ? beingLoaded : document ? document->loaded->source : options.scene;
}

void Viewer::load() {
  loading = true;
  beingLoaded = *toLoad;
  toLoad.reset();
  worker.start("loading " + nameOf(beingLoaded), [this, source = beingLoaded] { loaded = loadModel(source, options); });
}

void Viewer::addLoaded() {
  loading = false;
  std::string failure;
  try {
    worker.join();
    showLoaded();
  } catch (const Canceled&) {
    if (interrupted()) throw;
  } catch (const std::bad_alloc&) {
    failure = "not enough memory to load this model";
  } catch (const std::exception& e) { failure = e.what(); }
  if (!failure.empty()) {
    std::fprintf(stderr, "cbvh_viewer: %s\n", failure.c_str());
    lastMessage = failure;
  }
  requestScenes();
}

/* Keeps the view after a new map or amplitude. */
void Viewer::showLoaded() {
  const bool otherCage = !document || !sameCage(document->loaded->source, loaded->source);
  document = std::make_unique<Document>(std::move(loaded), options, worker);
  if (otherCage) {
    upAxis = document->model().up;
    hints = document->model().view;
    viewpoint.emplace(*document->loaded->start, hints.up);
    framing.reset();
    if (options.view == "full") framing = hints;
    framedSize = options.size;
    stepLength = 0.02f * viewpoint->distance();
  }
  rendered.reset();
  requested.camera.reset();
  latestCamera.reset();
  shown = requested;
  const std::string warnings =
      document->loaded->warnings + motionWarnings(document->model(), requested.representations);
  printWarnings("cbvh_viewer", warnings);
  lastMessage = prefixLines("warning: ", warnings);
}

/* --- every frame ------------------------------------------------------------------------- */

void Viewer::update() {
  if (loading && worker.finished()) addLoaded();
  if (document) {
    document->store.poll();
    showSeamWarning();
  }
  if (toLoad && !worker.hasTask()) load();
  followCamera();
  if (document && shown != requested && (isPreview() || !findPanes(requested, *document).empty())) {
    shown = requested;
    requestScenes();
    rendered.reset();
  }
}

/* Once per model. */
void Viewer::showSeamWarning() {
  if (!document->seamWarning.empty()) return;
  const std::string warning = seamWarnings(document->model(), document->store.largestSeamGap());
  if (warning.empty()) return;
  document->seamWarning = warning;
  printWarnings("cbvh_viewer", warning);
  lastMessage = prefixLines("warning: ", warning);
}

/* Rates by the view change once the camera has rested. */
void Viewer::followCamera() {
  constexpr std::chrono::milliseconds rest(300);
  if (!needsCamera() || !latestCamera || toLoad || loading) return;
  const std::optional<Camera> now = viewpoint->camera(size);
  if (!isSameView(now, latestCamera)) {
    latestCamera = now;
    cameraMoved = std::chrono::steady_clock::now();
  }
  const bool isResting = std::chrono::steady_clock::now() - cameraMoved >= rest;
  if (isSameView(now, requested.camera) || (requested.camera && !isResting)) return;
  requested.camera = now;
  requestScenes();
}

std::vector<Pane> Viewer::panes() const { return document ? findPanes(shown, *document) : std::vector<Pane>(); }

std::vector<Pane> Viewer::panesOrPreview() const {
  const std::vector<Pane> found = panes();
  if (!found.empty() || !document) return found;
  return {Pane(document->loaded->preview.get())};
}

/* Reports damage once; undamaged parts are shown. */
void Viewer::checkFile() {
  if (!isFile()) return;
  try {
    document->loaded->saved->check();
  } catch (const Error& e) {
    std::fprintf(stderr, "cbvh_viewer: %s\n", e.what());
    lastMessage = e.what();
  }
}

PictureMode Viewer::picturedMode() const {
  const std::vector<Pane> all = panesOrPreview();
  return all.empty() || all[0].canShow(shown.mode) ? shown.mode : PictureMode::Shading;
}

bool Viewer::refresh(ImageSize now) {
  size = now;
  const std::vector<Pane> all = panesOrPreview();
  if (all.empty()) return false;
  if (framing && (framedSize.width != size.width || framedSize.height != size.height)) frame(ViewHints(*framing));
  const Camera camera = viewpoint->camera(size);
  if (!latestCamera) latestCamera = camera;
  const std::string description = camera.description();
  const auto isRendered = [&] {
    const ImageSize last = rendered->image().size;
    return last.width == size.width && last.height == size.height && description == renderedCamera &&
           splitPosition == renderedSplit && shownTime == renderedTime && sameScenes(all, renderedPanes);
  };
  const bool same = rendered && isRendered();
  if (same && !continuous) {
    if (rendered->isComplete()) return false;
    rendered->addSample();
    checkFile();
    return true;
  }
  PictureSettings settings;
  settings.mode = picturedMode();
  settings.up = hints.up;
  settings.split = splitPosition;
  settings.threads = threadCount(options.build.threads);
  settings.samples = options.samples;
  settings.time = shownTime;
  rendered.emplace(camera, all, settings);
  rendered->addSample();
  checkFile();
  renderedCamera = description;
  renderedSplit = splitPosition;
  renderedTime = shownTime;
  renderedPanes = all;
  return true;
}

/* --- requests ---------------------------------------------------------------------------- */

void Viewer::requestState(const ViewState& state) {
  if (state == requested) return;
  if (isFile()) {
    const PictureMode mode = state.mode;
    if (mode == requested.mode) {
      lastMessage = "a file can only be shown in its own representation and level";
      return;
    }
    requested.mode = mode;
  } else requested = state;
  lastMessage.clear();
  if (document) lastMessage = prefixLines("warning: ", motionWarnings(document->model(), requested.representations));
  if (isFile() && !panes()[0].canShow(requested.mode))
    lastMessage = "mode " + std::string(pictureModeName(requested.mode)) + " needs a model, but a file contains none";
  requestScenes();
}

/* Keeps the shown scenes until the requested ones are built. */
void Viewer::requestScenes() {
  if (!document || toLoad || loading || isFile()) return; // called again after loading
  if (needsCamera() && !requested.camera) return;         // called again with the size of the picture
  std::vector<SceneKey> keys = requested.scenes();
  if (!isPreview())
    for (const SceneKey& key : shown.scenes()) keys.push_back(key);
  document->store.request(keys);
}

void Viewer::setSplit(bool split) {
  if (split == isSplit() || isFile()) return;
  ViewState state = requested;
  if (split) state.representations.push_back(other);
  else {
    other = state.representations[1];
    state.representations.pop_back();
  }
  requestState(state);
}

void Viewer::moveSplit(float position) {
  constexpr float margin = 0.02f; // within reach of the mouse
  splitPosition = std::clamp(position, margin, 1.0f - margin);
}

void Viewer::setTime(float time) { shownTime = std::clamp(time, 0.0f, 1.0f); }

void Viewer::stop() {
  toLoad.reset();
  if (loading) worker.cancel();
  else if (document) {
    requested = shown;
    document->store.request(isPreview() || isFile() ? std::vector<SceneKey>() : shown.scenes());
  }
}

std::string Viewer::message() const {
  return document && !document->store.failure().empty() ? document->store.failure() : lastMessage;
}

void Viewer::savePicture() {
  if (!rendered || shown != requested || isPreview()) lastMessage = "not saved: the picture is not ready yet";
  else try {
      while (!rendered->isComplete()) rendered->addSample();
      writePng(options.output, rendered->image());
      lastMessage = "saved " + options.output;
    } catch (const Error& e) { lastMessage = e.what(); }
  std::printf("%s\n", lastMessage.c_str());
  std::fflush(stdout);
}

/* --- the camera -------------------------------------------------------------------------- */

/* The whole model, at the current size. */
void Viewer::frame(const ViewHints& from) {
  framing = from;
  framedSize = size;
  viewpoint->set(fitCamera(document->model(), document->loaded->first().bounds(), from, viewpoint->fov(), size));
}

void Viewer::resetView() {
  if (!viewpoint) return;
  if (options.view == "full" || upAxis != document->model().up) frame(hints);
  else viewpoint->set(*document->loaded->start);
}

void Viewer::fitView() {
  if (!viewpoint) return;
  ViewHints from = hints;
  from.direction = viewpoint->direction();
  frame(from);
}

std::string Viewer::viewOptions() const {
  if (!viewpoint) return "";
  const bool turned = upAxis != document->model().up && (isFile() || !document->loaded->source.cagePath.empty());
  return "--view " + viewpoint->camera(size).description() + (turned ? " --up " + upAxis : "");
}

bool Viewer::isUpGuessed() const { return document && document->model().isUpGuessed && upAxis == document->model().up; }

void Viewer::setUp(const std::string& axis) {
  if (!viewpoint || axis == upAxis) return;
  upAxis = axis;
  hints = rotatedFromY(rotatedToY(document->model().view, document->model().up), axis);
  const Camera camera = viewpoint->camera(size);
  viewpoint.emplace(camera, hints.up);
  frame(hints);
  rendered.reset(); // the light depends on the up axis
}

void Viewer::orbit(float right, float upwards) {
  leaveFrame();
  if (viewpoint) viewpoint->orbit(right, upwards);
}

void Viewer::look(float right, float upwards) {
  leaveFrame();
  if (viewpoint) viewpoint->look(right, upwards);
}

void Viewer::walk(float right, float forward) {
  leaveFrame();
  if (viewpoint) viewpoint->move(stepLength * right, stepLength * forward);
}

void Viewer::pan(Vec2f pixels, float depth) {
  leaveFrame();
  if (viewpoint) viewpoint->pan(pixels.x, pixels.y, depth, size);
}

std::optional<Vec3f> Viewer::pointAt(Vec2f pixel) const {
  const std::vector<Pane> all = panesOrPreview();
  if (all.empty()) return std::nullopt;
  const bool left = pixel.x < float(splitColumn(size, splitPosition));
  Ray ray;
  ray.origin = viewpoint->position();
  ray.direction = viewpoint->camera(size).direction(pixel.x, pixel.y);
  ray.time = shownTime;
  SurfaceHit hit;
  traceClosest(*(left ? all.front() : all.back()).scene, 1, &ray, &hit);
  if (!hit.hit()) return std::nullopt;
  return ray.origin + hit.t * ray.direction;
}

/* The visible point, otherwise the point in the target's plane. */
Vec3f Viewer::pointOrTargetAt(Vec2f pixel) const {
  if (const std::optional<Vec3f> point = pointAt(pixel)) return *point;
  const Vec3f direction = viewpoint->camera(size).direction(pixel.x, pixel.y);
  return viewpoint->position() + (viewpoint->distance() / dot(direction, viewpoint->direction())) * direction;
}

float Viewer::depthAt(Vec2f pixel) const {
  return viewpoint ? dot(pointOrTargetAt(pixel) - viewpoint->position(), viewpoint->direction()) : 0.0f;
}

void Viewer::zoomAt(Vec2f pixel, float factor) {
  leaveFrame();
  if (viewpoint) viewpoint->zoom(pointOrTargetAt(pixel), 1.0f / factor);
}

void Viewer::zoom(float factor) {
  leaveFrame();
  if (viewpoint) viewpoint->zoom(viewpoint->position() + viewpoint->distance() * viewpoint->direction(), 1.0f / factor);
}

void Viewer::centerAt(Vec2f pixel) {
  if (const std::optional<Vec3f> point = pointAt(pixel)) {
    leaveFrame();
    viewpoint->lookAt(*point);
  }
}

} // namespace programs
