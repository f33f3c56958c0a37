// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "layout.h"

#include <algorithm>

namespace programs {
namespace {

/* Removes rows from the top of `rest` and returns them; at least one row remains. */
Rectangle splitRows(Rectangle& rest, int rows) {
  const Rectangle part{rest.x, rest.y, rest.width, std::min(rows, rest.height - 1)};
  rest.y += part.height;
  rest.height -= part.height;
  return part;
}

Rectangle splitColumns(Rectangle& rest, int columns) {
  const Rectangle part{rest.x, rest.y, columns, rest.height};
  rest.x += columns;
  rest.width -= columns;
  return part;
}

} // namespace

WindowLayout computeLayout(ImageSize window, PanelState panel, bool split) {
  WindowLayout layout;
  layout.picture = {0, 0, window.width, window.height};
  if (panel == PanelState::Hidden) return layout;
  if (panel == PanelState::Folded) layout.panel = splitRows(layout.picture, barHeight);
  else if (window.width >= 2 * panelWidth) layout.panel = splitColumns(layout.picture, panelWidth);
  else layout.panel = splitRows(layout.picture, window.height / 2);
  if (split) layout.captions = splitRows(layout.picture, barHeight);
  return layout;
}

} // namespace programs
