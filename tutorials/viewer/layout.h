// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Positions of panel, captions and picture in the window. They do not overlap, so that the panel never covers the part
 * of the picture that it describes.
 *
 * All values are in units of the window, from its upper left corner. */

#include "tracing/image_size.h"

namespace cbvh {

struct Rectangle
{
  int x = 0, y = 0, width = 0, height = 0;
};

enum class PanelState
{
  Open,
  Folded, // only its title bar
  Hidden, // neither panel nor captions
};

struct WindowLayout
{
  Rectangle panel;    // without area if hidden
  Rectangle captions; // of the halves of a split screen; without area if there are none
  Rectangle picture;  // at least a pixel
};

constexpr int panelWidth = 300, barHeight = 19; // fit the panel's text in ImGui's font

/* The panel is on the left if the window is wide enough, otherwise above the picture. The window must be at least
 * 1 x 1. */
WindowLayout layOut(ImageSize window, PanelState panel, bool split);

} // namespace cbvh
