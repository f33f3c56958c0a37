// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Where panel, captions and picture lie in the window. They share it: none covers another, as what
 * is looked at must not be under what is said about it.
 *
 * All in units of the window, from its upper left. */

#include "tracing/image_size.h"

namespace cbvh {

struct Rectangle
{
  int x = 0, y = 0, width = 0, height = 0;
};

enum class PanelState
{
  Open,
  Folded, // a bar with its title
  Hidden, // nothing but the picture, captions neither
};

struct WindowLayout
{
  Rectangle panel;    // without area while hidden
  Rectangle captions; // of the halves of a split screen; without area where there is none
  Rectangle picture;  // of at least a pixel
};

constexpr int panelWidth = 300, barHeight = 19; // of ImGui's font: what the panel says fits into it

/* The panel is at the left of a window that has room for it, else above the picture.
 *
 * window: at least 1 x 1. */
WindowLayout layOut(ImageSize window, PanelState panel, bool split);

} // namespace cbvh
