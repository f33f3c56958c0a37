// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What is looked at, as far as it can be switched while running, and the scenes that
 * this takes. */

#include "document.h"
#include "picture.h"

#include <vector>

namespace cbvh {

struct ViewState
{
  std::vector<Representation> representations; // one, or two for a split screen
  int level = 6;                               // or autoLevel
  PictureMode mode = PictureMode::Shading;
  std::optional<Camera> camera;                // that autoLevel is for; none of meshes

  /* How a representation is built. */
  SceneKey key(const Representation& r) const;

  /* What has to be built, GRID for its errors included. */
  std::vector<SceneKey> scenes() const;
};

/* Empty until all scenes of the state are built; of a file always what is in it. */
std::vector<Pane> findPanes(const ViewState& state, const Document& document);

bool operator==(const ViewState& a, const ViewState& b);
inline bool operator!=(const ViewState& a, const ViewState& b) { return !(a == b); }

} // namespace cbvh
