// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* State that the user can change at run time, and the scenes that it needs. */

#include "document.h"
#include "picture.h"

#include <vector>

namespace programs {

struct ViewState {
  std::vector<Representation> representations; // one, or two for a split screen
  int level = 6;                               // or autoLevel
  PictureMode mode = PictureMode::Shading;
  std::optional<Camera> camera; // for autoLevel; unset for meshes

  SceneKey key(const Representation& r) const;

  /* Includes GRID for errors. */
  std::vector<SceneKey> scenes() const;
};

/* Panes; none until all scenes are built. A file has one. */
std::vector<Pane> findPanes(const ViewState& state, const Document& document);

bool operator==(const ViewState& a, const ViewState& b);
inline bool operator!=(const ViewState& a, const ViewState& b) { return !(a == b); }

/* The representations that the number keys select, from 1 on. NAIVE-compact is the last. */
std::vector<RepresentationKind> kindsOfKeys();

} // namespace programs
