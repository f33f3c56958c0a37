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

namespace cbvh {
namespace {

std::string nameOf(const SceneSettings& source)
{
  return source.scene.empty() ? std::filesystem::path(source.cagePath + source.meshPath + source.savedPath).filename().string() : source.scene;
}

bool sameCage(const SceneSettings& a, const SceneSettings& b)
{
  return a.scene == b.scene && a.cagePath == b.cagePath && a.meshPath == b.meshPath && a.savedPath == b.savedPath;
}

bool sameScenes(const std::vector<Pane>& a, const std::vector<Pane>& b)
{
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Pane& x, const Pane& y) { return x.scene == y.scene && x.reference == y.reference; });
}

} // namespace

Viewer::Viewer(const ViewerOptions& options) : options(options), shownTime(options.time)
{
  worker.listen();
  wanted.representations = options.representations;
  wanted.level = options.autoLevel ? autoLevel : options.build.level;
  wanted.mode = options.mode;
  shown = wanted;
  if (!options.scene.scene.empty() || !options.scene.cagePath.empty() || !options.scene.meshPath.empty() || !options.scene.savedPath.empty())
    open(options.scene);
}

/* --- files ------------------------------------------------------------------------------- */

void Viewer::open(const SceneSettings& source)
{
  toLoad = source;
  lastMessage.clear();
  if (loading)
    worker.cancel();
  if (document)
    document->store.request({});
}

void Viewer::openFiles(const std::vector<std::string>& paths)
{
  try
  {
    open(cbvh::openFiles(paths, latestSource()));
  }
  catch (const Error& e)
  {
    lastMessage = e.what();
  }
}

void Viewer::setStrength(float strength)
{
  SceneSettings source = withDefaultAmplitude(latestSource());
  std::optional<float>& given = source.mapScale ? source.mapScale : source.amplitude;
  if (given && *given != strength)
  {
    given = strength;
    open(source);
  }
}

const SceneSettings& Viewer::latestSource() const
{
  return toLoad ? *toLoad : loading ? beingLoaded : document ? document->loaded->source : options.scene;
}

void Viewer::load()
{
  loading = true;
  beingLoaded = *toLoad;
  toLoad.reset();
  worker.start("loading " + nameOf(beingLoaded), [this, source = beingLoaded] { loaded = loadModel(source, options); });
}

void Viewer::takeLoaded()
{
  loading = false;
  std::string failure;
  try
  {
    worker.take();
    showLoaded();
  }
  catch (const Cancelled&)
  {
    if (interrupted())
      throw;
  }
  catch (const std::bad_alloc&)
  {
    failure = "not enough memory to load that";
  }
  catch (const std::exception& e)
  {
    failure = e.what();
  }
  if (!failure.empty())
  {
    std::fprintf(stderr, "cbvh_viewer: %s\n", failure.c_str());
    lastMessage = failure;
  }
  requestScenes();
}

/* Another map or amplitude is looked at from where the user stands. */
void Viewer::showLoaded()
{
  const bool otherCage = !document || !sameCage(document->loaded->source, loaded->source);
  document = std::make_unique<Document>(std::move(loaded), options, worker);
  if (otherCage)
  {
    upAxis = document->model().up;
    hints = document->model().view;
    viewpoint.emplace(*document->loaded->start, hints.up);
    framing.reset();
    if (options.view == "full")
      framing = hints;
    framedSize = options.size;
    stepLength = 0.02f * viewpoint->distance();
  }
  rendered.reset();
  wanted.camera.reset();
  latestCamera.reset();
  shown = wanted;
  printWarnings("cbvh_viewer", document->loaded->warnings);
  lastMessage = prefixLines("warning: ", document->loaded->warnings);
}

/* --- every frame ------------------------------------------------------------------------- */

void Viewer::update()
{
  if (loading && worker.finished())
    takeLoaded();
  if (document)
    document->store.poll();
  if (toLoad && !worker.busy())
    load();
  followCamera();
  if (document && shown != wanted && (isPreview() || !findPanes(wanted, *document).empty()))
  {
    shown = wanted;
    requestScenes();
    rendered.reset();
  }
}

/* Rates by the view are those of the view where the camera rests. */
void Viewer::followCamera()
{
  constexpr std::chrono::milliseconds rest(300);
  if (!needsCamera() || !latestCamera || toLoad || loading)
    return;
  const std::optional<Camera> now = viewpoint->camera(size);
  if (!isSameView(now, latestCamera))
  {
    latestCamera = now;
    cameraMoved = std::chrono::steady_clock::now();
  }
  if (isSameView(now, wanted.camera) || (wanted.camera && std::chrono::steady_clock::now() - cameraMoved < rest))
    return;
  wanted.camera = now;
  requestScenes();
}

std::vector<Pane> Viewer::panes() const
{
  return document ? findPanes(shown, *document) : std::vector<Pane>();
}

std::vector<Pane> Viewer::panesOrPreview() const
{
  const std::vector<Pane> found = panes();
  if (!found.empty() || !document)
    return found;
  return {Pane(document->loaded->preview.get())};
}

/* What is damaged is told once, and the rest is shown. */
void Viewer::checkFile()
{
  if (!isFile())
    return;
  try
  {
    document->loaded->saved->check();
  }
  catch (const Error& e)
  {
    std::fprintf(stderr, "cbvh_viewer: %s\n", e.what());
    lastMessage = e.what();
  }
}

PictureMode Viewer::picturedMode() const
{
  const std::vector<Pane> what = panesOrPreview();
  return what.empty() || what[0].canShow(shown.mode) ? shown.mode : PictureMode::Shading;
}

bool Viewer::refresh(ImageSize now)
{
  size = now;
  const std::vector<Pane> what = panesOrPreview();
  if (what.empty())
    return false;
  if (framing && (framedSize.width != size.width || framedSize.height != size.height))
    frame(ViewHints(*framing));
  const Camera camera = viewpoint->camera(size);
  if (!latestCamera)
    latestCamera = camera;
  const std::string description = camera.description();
  const bool same = rendered && rendered->image().size.width == size.width && rendered->image().size.height == size.height &&
                    description == renderedCamera && splitPosition == renderedSplit && shownTime == renderedTime && sameScenes(what, renderedPanes);
  if (same && !continuous)
  {
    if (rendered->isComplete())
      return false;
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
  rendered.emplace(camera, what, settings);
  rendered->addSample();
  checkFile();
  renderedCamera = description;
  renderedSplit = splitPosition;
  renderedTime = shownTime;
  renderedPanes = what;
  return true;
}

/* --- what is wanted ---------------------------------------------------------------------- */

void Viewer::want(const ViewState& state)
{
  if (state == wanted)
    return;
  if (isFile())
  {
    const PictureMode mode = state.mode;
    if (mode == wanted.mode)
    {
      lastMessage = "a file shows what is in it, at the level that it was written with";
      return;
    }
    wanted.mode = mode;
  }
  else
    wanted = state;
  lastMessage.clear();
  if (isFile() && !panes()[0].canShow(wanted.mode))
    lastMessage = "mode " + std::string(pictureModeName(wanted.mode)) + " needs the model, which a file has not";
  requestScenes();
}

/* What is shown stays until what is wanted is there. */
void Viewer::requestScenes()
{
  if (!document || toLoad || loading || isFile())
    return; // asked for when that has ended
  if (needsCamera() && !wanted.camera)
    return; // asked for when the size of the picture is known
  std::vector<SceneKey> keys = wanted.scenes();
  if (!isPreview())
    for (const SceneKey& key : shown.scenes())
      keys.push_back(key);
  document->store.request(keys);
}

void Viewer::setSplit(bool split)
{
  if (split == isSplit() || isFile())
    return;
  ViewState state = wanted;
  if (split)
    state.representations.push_back(other);
  else
  {
    other = state.representations[1];
    state.representations.pop_back();
  }
  want(state);
}

void Viewer::moveSplit(float position)
{
  constexpr float rim = 0.02f; // it can be caught again
  splitPosition = std::clamp(position, rim, 1.0f - rim);
}

void Viewer::setTime(float time)
{
  shownTime = std::clamp(time, 0.0f, 1.0f);
}

void Viewer::stop()
{
  toLoad.reset();
  if (loading)
    worker.cancel();
  else if (document)
  {
    wanted = shown;
    document->store.request(isPreview() || isFile() ? std::vector<SceneKey>() : shown.scenes());
  }
}

std::string Viewer::message() const
{
  return document && !document->store.failure().empty() ? document->store.failure() : lastMessage;
}

void Viewer::savePicture()
{
  if (!rendered || shown != wanted || isPreview())
    lastMessage = "not saved: the picture is not there yet";
  else
    try
    {
      while (!rendered->isComplete())
        rendered->addSample();
      writePng(options.picture, rendered->image());
      lastMessage = "saved " + options.picture;
    }
    catch (const Error& e)
    {
      lastMessage = e.what();
    }
  std::printf("%s\n", lastMessage.c_str());
  std::fflush(stdout);
}

/* --- the camera -------------------------------------------------------------------------- */

/* From there as it starts, at the size that it has now. */
void Viewer::frame(const ViewHints& from)
{
  framing = from;
  framedSize = size;
  viewpoint->set(fitCamera(document->model(), document->loaded->first().bounds(), from, viewpoint->fov(), size));
}

void Viewer::resetView()
{
  if (!viewpoint)
    return;
  if (options.view == "full" || upAxis != document->model().up)
    frame(hints);
  else
    viewpoint->set(*document->loaded->start);
}

void Viewer::fitView()
{
  if (!viewpoint)
    return;
  ViewHints from = hints;
  from.direction = viewpoint->direction();
  frame(from);
}

std::string Viewer::viewOptions() const
{
  if (!viewpoint)
    return "";
  const bool turned = upAxis != document->model().up && (isFile() || !document->loaded->source.cagePath.empty());
  return "--view " + viewpoint->camera(size).description() + (turned ? " --up " + upAxis : "");
}

bool Viewer::isUpGuessed() const
{
  return document && document->model().isUpGuessed && upAxis == document->model().up;
}

void Viewer::turnUp(const std::string& axis)
{
  if (!viewpoint || axis == upAxis)
    return;
  upAxis = axis;
  hints = turnedFromY(turnedToY(document->model().view, document->model().up), axis);
  const Camera camera = viewpoint->camera(size);
  viewpoint.emplace(camera, hints.up);
  frame(hints);
  rendered.reset(); // its light came from another side
}

void Viewer::orbit(float right, float upwards)
{
  leaveFrame();
  if (viewpoint)
    viewpoint->orbit(right, upwards);
}

void Viewer::look(float right, float upwards)
{
  leaveFrame();
  if (viewpoint)
    viewpoint->look(right, upwards);
}

void Viewer::walk(float right, float forward)
{
  leaveFrame();
  if (viewpoint)
    viewpoint->move(stepLength * right, stepLength * forward);
}

void Viewer::pan(Vec2f pixels, float depth)
{
  leaveFrame();
  if (viewpoint)
    viewpoint->pan(pixels.x, pixels.y, depth, size);
}

std::optional<Vec3f> Viewer::pointAt(Vec2f pixel) const
{
  const std::vector<Pane> all = panesOrPreview();
  if (all.empty())
    return std::nullopt;
  const bool left = pixel.x < float(splitColumn(size, splitPosition));
  Ray ray;
  ray.origin = viewpoint->position();
  ray.direction = viewpoint->camera(size).direction(pixel.x, pixel.y);
  ray.time = shownTime;
  SurfaceHit hit;
  traceClosest(*(left ? all.front() : all.back()).scene, 1, &ray, &hit);
  if (!hit.hit())
    return std::nullopt;
  return ray.origin + hit.t * ray.direction;
}

/* In the plane of the target where nothing is seen. */
Vec3f Viewer::pointOrTargetAt(Vec2f pixel) const
{
  if (const std::optional<Vec3f> point = pointAt(pixel))
    return *point;
  const Vec3f direction = viewpoint->camera(size).direction(pixel.x, pixel.y);
  return viewpoint->position() + (viewpoint->distance() / dot(direction, viewpoint->direction())) * direction;
}

float Viewer::depthAt(Vec2f pixel) const
{
  return viewpoint ? dot(pointOrTargetAt(pixel) - viewpoint->position(), viewpoint->direction()) : 0.0f;
}

void Viewer::zoomAt(Vec2f pixel, float factor)
{
  leaveFrame();
  if (viewpoint)
    viewpoint->zoom(pointOrTargetAt(pixel), 1.0f / factor);
}

void Viewer::zoom(float factor)
{
  leaveFrame();
  if (viewpoint)
    viewpoint->zoom(viewpoint->position() + viewpoint->distance() * viewpoint->direction(), 1.0f / factor);
}

void Viewer::centreAt(Vec2f pixel)
{
  if (const std::optional<Vec3f> point = pointAt(pixel))
  {
    leaveFrame();
    viewpoint->lookAt(*point);
  }
}

} // namespace cbvh
