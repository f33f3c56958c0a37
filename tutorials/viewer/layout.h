// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Panel, captions and picture do not overlap, so that the panel never covers what it describes.
 *
 * Units are the window's, from its upper left corner. */

#include "tracing/image_size.h"

namespace programs {

struct Rectangle {
  int x = 0, y = 0, width = 0, height = 0;
};

enum class PanelState {
  Open,
  Folded, // its title bar
  Hidden, // neither panel nor captions
};

struct WindowLayout {
  Rectangle panel;    // empty if hidden
  Rectangle captions; // of a split screen; otherwise empty
  Rectangle picture;  // at least a pixel
};

constexpr int panelWidth = 300, barHeight = 19; // fit the panel's text

/* The panel is on the left of a wide window, otherwise above the picture. The window must be at least 1 x 1. */
WindowLayout computeLayout(ImageSize window, PanelState panel, bool split);

} // namespace programs
