// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "view_state.h"

#include <algorithm>

namespace programs {

SceneKey ViewState::key(const Representation& r) const {
  return {r, level, level == autoLevel && !r.isTriangulated() ? camera : std::nullopt};
}

std::vector<SceneKey> ViewState::scenes() const {
  std::vector<SceneKey> keys;
  for (const Representation& r : representations) keys.push_back(key(r));
  if (mode == PictureMode::Error) keys.push_back(key({RepresentationKind::Grid}));
  return keys;
}

std::vector<Pane> findPanes(const ViewState& state, const Document& document) {
  if (document.loaded->saved) return {Pane(document.loaded->saved.get())};
  const SceneStore& store = document.store;
  std::vector<Pane> panes;
  for (const Representation& r : state.representations) {
    const Pane pane(store.find(state.key(r)), store.find(state.key({RepresentationKind::Grid})));
    if (!pane.scene || (state.mode == PictureMode::Error && !pane.reference)) return {};
    panes.push_back(pane);
  }
  return panes;
}

bool operator==(const ViewState& a, const ViewState& b) {
  if (a.representations.size() != b.representations.size() || a.level != b.level || a.mode != b.mode) return false;
  for (size_t i = 0; i < a.representations.size(); i++)
    if (a.key(a.representations[i]) != b.key(b.representations[i])) return false;
  return true;
}

std::vector<RepresentationKind> kindsOfKeys() {
  std::vector<RepresentationKind> kinds = representationKinds();
  std::stable_partition(kinds.begin(), kinds.end(),
                        [](RepresentationKind kind) { return kind != RepresentationKind::NaiveCompact; });
  return kinds;
}

} // namespace programs
