// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What lies over the picture, drawn with ImGui: the panel with settings and figures,
 * the bar of what is under way, and the question before the end. */

#include "viewer.h"

namespace cbvh {

class Panel
{
public:
  explicit Panel(Viewer& viewer, unsigned threads) : viewer(viewer), threads(threads) {}

  /* Draws all of it. Called between ImGui's NewFrame and Render. */
  void draw();

  void fold() { changeFold = true; }
  void hide() { hidden = !hidden; }

  /* Asks whether to end. The keys of the answer are the window's. */
  void ask(bool now) { asking = now; }
  bool isAsking() const { return asking; }
  bool quitChosen() const { return quit; }

private:
  void drawPanel();
  void drawSettings();
  void drawStrength();
  void drawReports();
  void drawSamples();
  void drawLegend();
  void drawProgress();
  void drawQuestion();

  Viewer& viewer;
  const unsigned threads;
  float strength = 0; // of the displacement, while it is being changed
  bool changesStrength = false;
  bool changeFold = false, folded = false, hidden = false, asking = false, quit = false;
};

} // namespace cbvh
