// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What is said about the picture, drawn with ImGui: the panel with settings and figures, what is
 * under way, the captions of a split screen, and the question before the end. */

#include "layout.h"
#include "viewer.h"

namespace cbvh {

class Panel
{
public:
  explicit Panel(Viewer& viewer, unsigned threads) : viewer(viewer), threads(threads) {}

  /* Draws all of it. Called between ImGui's NewFrame and Render. */
  void draw();

  /* Where it leaves room for the picture. window: in units of the window, at least 1 x 1. */
  WindowLayout layout(ImageSize window) const;

  void fold() { changeFold = true; }
  void hide() { hidden = !hidden; }

  /* Asks whether to end. The keys of the answer are the window's. */
  void ask(bool now) { asking = now; }
  bool isAsking() const { return asking; }
  bool quitChosen() const { return quit; }

private:
  PanelState state() const { return hidden ? PanelState::Hidden : folded ? PanelState::Folded : PanelState::Open; }
  std::string title() const;
  void drawPanel(const Rectangle& area);
  void drawCaptions(const Rectangle& area);
  void drawSettings();
  void drawTime();
  void drawUp();
  void drawKeys();
  void drawFooter();
  void drawStrength();
  void drawBuilt(const BuiltScene& scene, const char* side);
  void drawSaved(const SavedScene& scene);
  void drawReports();
  void drawSamples();
  void drawLegend();
  void drawMessage();
  void drawProgress(const Worker::Progress& progress);
  void drawMiddle();
  void drawQuestion();

  Viewer& viewer;
  const unsigned threads;
  float strength = 0; // of the displacement, while it is being changed
  bool changesStrength = false;
  bool changeFold = false, folded = false, hidden = false, asking = false, quit = false;
};

} // namespace cbvh
