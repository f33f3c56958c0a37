// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a viewer shows and what the user wants it to show, without the window around it.
 * Whatever takes long goes on in the background; until it is there, what was shown stays.
 * A model that is shown as a whole stays so when the picture gets another size.
 *
 * Pixels are those of the picture, from the upper left. */

#include "document.h"
#include "view_state.h"
#include "viewpoint.h"
#include "worker.h"

#include <chrono>

namespace cbvh {

class Viewer
{
public:
  /* options: outlives the viewer. Opens their scene, if they name one. */
  explicit Viewer(const ViewerOptions& options);

  /* --- files --- */

  /* Loads a scene in place of the one that is shown. */
  void open(const SceneSettings& source);

  /* The same for files, see openFiles in opened_files.h. */
  void openFiles(const std::vector<std::string>& paths);

  /* Loads the same with its displacement at another amplitude, or at another scale where that
   * is what was given. Nothing for what has no displacement. */
  void setStrength(float strength);

  /* Whether what is opened is a file of compressed surfaces: its kinds and levels are those that it was written with. */
  bool isFile() const { return document && document->loaded->saved; }

  /* Null while there is none yet. */
  const LoadedModel* opened() const { return document ? document->loaded.get() : nullptr; }

  /* --- every frame --- */

  /* Takes over what the background has finished, and starts what is to be done next.
   * Throws Cancelled when a signal asked for the end. */
  void update();

  /* Renders if anything changed since the last call, else adds a sample to the picture, if it is to
   * have more. Says whether it did either. */
  bool refresh(ImageSize size);

  /* As refresh left it; null while there is nothing to show. */
  const Picture* picture() const { return rendered ? &*rendered : nullptr; }

  /* What is shown, one or two; empty while nothing or a preview is. */
  std::vector<Pane> panes() const;
  bool isPreview() const { return document && panes().empty(); }

  /* --- what is wanted --- */

  const ViewState& state() const { return wanted; }
  PictureMode picturedMode() const; // shading where there is not what the mode takes
  int shownLevel() const { return shown.level; }
  void want(const ViewState& state);
  bool isSplit() const { return wanted.representations.size() == 2; }
  void setSplit(bool split);

  /* Where the right half starts, of the width. */
  float split() const { return splitPosition; }
  void moveSplit(float position);

  /* When the model is shown, from 0 to 1, if it moves. */
  bool moves() const { return document && document->loaded->moves(); }
  float time() const { return shownTime; }
  void setTime(float time);

  /* What is under way, if anything is. */
  std::optional<Worker::Progress> progress() const { return worker.progress(); }

  /* Gives up what is under way. */
  void stop();

  /* Why there is not what was wanted, or what was done last; a line, or empty. */
  std::string message() const;

  /* Writes the picture that is shown, with all its samples. */
  void savePicture();

  bool continuous = false; // renders although nothing changed

  /* --- the camera; nothing happens while there is no model --- */

  void resetView();
  void fitView();

  /* The options that show the same: --view, and --up where turnUp chose another axis for a cage. */
  std::string viewOptions() const;

  /* The axis that points upwards, one of upAxes(), and whether it is a guess. turnUp takes another
   * one and shows all of the model. */
  const std::string& up() const { return upAxis; }
  bool isUpGuessed() const;
  void turnUp(const std::string& axis);

  void orbit(float right, float upwards);
  void look(float right, float upwards);
  void walk(float right, float forward); // steps, of which there are about 50 to what is looked at
  void pan(Vec2f pixels, float depth);

  /* Distance of what is seen there along the view, of the target where nothing is. */
  float depthAt(Vec2f pixel) const;

  /* Brings what is seen there `factor` times as near. */
  void zoomAt(Vec2f pixel, float factor);
  void zoom(float factor);

  /* Turns to what is seen there, if anything is, and orbits about it. */
  void centreAt(Vec2f pixel);

private:
  const SceneSettings& latestSource() const; // that was asked for, whether it is there yet or not
  void load();
  void takeLoaded();
  void showLoaded();
  void frame(const ViewHints& from);
  void checkFile();
  void leaveFrame() { framing.reset(); }
  void requestScenes();
  void followCamera();
  bool needsCamera() const { return document && wanted.level == autoLevel && !document->model().isMesh && !isFile(); }
  std::vector<Pane> panesOrPreview() const;
  std::optional<Vec3f> pointAt(Vec2f pixel) const;
  Vec3f pointOrTargetAt(Vec2f pixel) const;

  const ViewerOptions& options;
  std::optional<SceneSettings> toLoad;
  bool loading = false;
  SceneSettings beingLoaded; // then
  std::unique_ptr<const LoadedModel> loaded; // by the worker, which is gone before this is,
  Worker worker;                             // and after the document, whose scenes it builds
  std::unique_ptr<Document> document;

  ViewState wanted, shown;
  Representation other{RepresentationKind::Grid}; // of the right half while there is none
  float splitPosition = 0.5f, stepLength = 1.0f;
  float shownTime;
  std::optional<Viewpoint> viewpoint; // as soon as there is a model
  std::string upAxis = "y";
  ViewHints hints;                    // of the model, turned to that
  std::optional<ViewHints> framing;   // from where all of it is shown, until the user moves
  ImageSize framedSize;

  ImageSize size{1, 1};
  std::optional<Picture> rendered;
  std::string renderedCamera; // what it was rendered with,
  float renderedSplit = 0.5f, renderedTime = 0.0f;
  std::vector<Pane> renderedPanes;
  std::optional<Camera> latestCamera;                // of the last frame,
  std::chrono::steady_clock::time_point cameraMoved; // and since when it has been there
  std::string lastMessage;
};

} // namespace cbvh
