// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Draws with ImGui: the panel with settings and figures, progress, captions, and the question before quitting. */

#include "layout.h"
#include "viewer.h"

namespace programs {

class Panel {
public:
  explicit Panel(Viewer& viewer, unsigned threads) : viewer(viewer), threads(threads) {}

  /* Call between ImGui's NewFrame and Render. */
  void draw();

  /* `window` is in units of the window and at least 1 x 1. */
  WindowLayout layout(ImageSize window) const;

  void toggleFolded() { foldToggled = true; }
  void toggleHidden() { hidden = !hidden; }

  /* Shows or hides the question whether to quit. The window handles the keys of the answer. */
  void askToQuit(bool show) { asking = show; }
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
  float strength = 0; // while the user changes it
  bool changesStrength = false;
  bool foldToggled = false, folded = false, hidden = false, asking = false, quit = false;
};

} // namespace programs
