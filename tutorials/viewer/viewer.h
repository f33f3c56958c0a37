// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A viewer without its window. Slow work runs in the background, while the previous scene stays visible. A model
 * that is shown as a whole stays so when the picture is resized.
 *
 * Pixels are the picture's, from the upper left. */

#include "document.h"
#include "view_state.h"
#include "viewpoint.h"
#include "worker.h"

#include <chrono>

namespace programs {

class Viewer {
public:
  /* Opens the scene of the options, if any. The options must outlive the viewer. */
  explicit Viewer(const ViewerOptions& options);

  /* --- files --- */

  void open(const SceneSettings& source);

  /* See opened_files.h. */
  void openFiles(const std::vector<std::string>& paths);

  /* Reloads the scene with another amplitude, or scale if the map has one. Does nothing without displacement. */
  void setStrength(float strength);

  /* Representations and levels of files are fixed. */
  bool isFile() const { return document && document->loaded->saved; }

  /* Null until a scene is loaded. */
  const LoadedModel* opened() const { return document ? document->loaded.get() : nullptr; }

  /* --- every frame --- */

  /* Adopts the result of a finished task and starts the next one. Throws Canceled after a signal. */
  void update();

  /* Renders after a change, or adds a sample to an incomplete picture. Returns true if it did. */
  bool refresh(ImageSize size);

  /* Null if there is nothing to show. */
  const Picture* picture() const { return rendered ? &*rendered : nullptr; }

  /* One or two; empty without a scene or with only a preview. */
  std::vector<Pane> panes() const;
  bool isPreview() const { return document && panes().empty(); }

  /* --- requests --- */

  const ViewState& state() const { return requested; }
  PictureMode picturedMode() const; // shading if the scene does not support the mode
  int shownLevel() const { return shown.level; }
  void requestState(const ViewState& state);
  bool isSplit() const { return requested.representations.size() == 2; }
  void setSplit(bool split);

  /* Where the right half starts, as a fraction of the width. */
  float split() const { return splitPosition; }
  void moveSplit(float position);

  /* Time at which a moving model is shown, 0 to 1. */
  bool moves() const { return document && document->loaded->moves(); }
  float time() const { return shownTime; }
  void setTime(float time);

  /* Progress of the background task, if any. */
  std::optional<Worker::Progress> progress() const { return worker.progress(); }

  /* Cancels the background task. */
  void stop();

  /* About the last failure or action, or empty. */
  std::string message() const;

  /* Saves the shown picture with all its samples. */
  void savePicture();

  bool continuous = false; // render even if nothing changed

  /* --- the camera; these do nothing while there is no model --- */

  void resetView();
  void fitView();

  /* Options for the same view: --view, and --up if setUp chose another axis for a cage or a file. */
  std::string viewOptions() const;

  /* One of upAxes(). setUp also shows the whole model. */
  const std::string& up() const { return upAxis; }
  bool isUpGuessed() const;
  void setUp(const std::string& axis);

  void orbit(float right, float upwards);
  void look(float right, float upwards);
  void walk(float right, float forward); // in steps, 50 to the first target
  void pan(Vec2f pixels, float depth);

  /* Distance along the view of the visible point, otherwise of the target; 0 without a model. */
  float depthAt(Vec2f pixel) const;

  /* Comes `factor` times as close to the visible point. */
  void zoomAt(Vec2f pixel, float factor);
  void zoom(float factor);

  /* The visible point, if any, becomes the center of orbits. */
  void centerAt(Vec2f pixel);

private:
  const SceneSettings& latestSource() const; // may not be loaded yet
  void load();
  void addLoaded();
  void showLoaded();
  void frame(const ViewHints& from);
  void checkFile();
  void leaveFrame() { framing.reset(); }
  void requestScenes();
  void followCamera();
  void showSeamWarning();
  bool needsCamera() const {
    return document && requested.level == autoLevel && !document->model().isMesh && !isFile();
  }
  std::vector<Pane> panesOrPreview() const;
  std::optional<Vec3f> pointAt(Vec2f pixel) const;
  Vec3f pointOrTargetAt(Vec2f pixel) const;

  const ViewerOptions& options;
  std::optional<SceneSettings> toLoad;
  bool loading = false;
  SceneSettings beingLoaded;                 // if loading
  std::unique_ptr<const LoadedModel> loaded; // by the worker, which is destroyed first
  Worker worker;                             // destroyed after the document, for which it builds
  std::unique_ptr<Document> document;

  ViewState requested, shown;
  Representation other{RepresentationKind::Grid}; // of the right half while the screen is not split
  float splitPosition = 0.5f, stepLength = 1.0f;
  float shownTime;
  std::optional<Viewpoint> viewpoint; // set with a model
  std::string upAxis = "y";
  ViewHints hints;                  // rotated to the up axis
  std::optional<ViewHints> framing; // of a view of the whole model, until the user moves
  ImageSize framedSize;

  ImageSize size{1, 1};
  std::optional<Picture> rendered;
  std::string renderedCamera; // for which it was rendered
  float renderedSplit = 0.5f, renderedTime = 0.0f;
  std::vector<Pane> renderedPanes;
  std::optional<Camera> latestCamera;                // of the last frame
  std::chrono::steady_clock::time_point cameraMoved; // time of its last change
  std::string lastMessage;
};

} // namespace programs
