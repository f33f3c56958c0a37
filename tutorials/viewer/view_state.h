// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The state of a view that can be changed at run time, and the scenes that it needs. */

#include "document.h"
#include "picture.h"

#include <vector>

namespace cbvh {

struct ViewState
{
  std::vector<Representation> representations; // one, or two for a split screen
  int level = 6;                               // or autoLevel
  PictureMode mode = PictureMode::Shading;
  std::optional<Camera> camera;                // for autoLevel; unset for meshes

  /* Returns the key of a representation's scene. */
  SceneKey key(const Representation& r) const;

  /* Returns the keys of all necessary scenes, including GRID for errors. */
  std::vector<SceneKey> scenes() const;
};

/* Returns the panes, or nothing until all scenes of the state are built. A file always has one pane. */
std::vector<Pane> findPanes(const ViewState& state, const Document& document);

bool operator==(const ViewState& a, const ViewState& b);
inline bool operator!=(const ViewState& a, const ViewState& b) { return !(a == b); }

} // namespace cbvh
