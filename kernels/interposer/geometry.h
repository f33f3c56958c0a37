// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* An application's geometry, for which scenes contain a substitute: a user geometry that traces the compressed surface.
 * The application's handle is Embree's geometry (the original), which receives all calls and interpolates. Scenes
 * contain the original only if it cannot be compressed, because Embree tessellates what a scene contains. */

#include "input.h"
#include "substitute_data.h"

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

namespace interposer {

/* Called with the completed fraction, 0 to 1, by several threads at the same time. Returns false to cancel. */
typedef std::function<bool(double)> Progress;

class Substituted {
public:
  /* Returns NULL if no substitute is possible. settings: of the context of libembree_cbvh. Throws std::bad_alloc. */
  static std::unique_ptr<Substituted> make(RTCDevice device, const std::string& settings, RTCGeometry original,
                                           RTCGeometryType type);
  ~Substituted();
  Substituted(const Substituted&) = delete;
  Substituted& operator=(const Substituted&) = delete;

  /* Input of the next build. As in Embree, a build reads the current input, including changes since the last commit of
   * the geometry: buffers that an application replaced may no longer exist. */
  Input input;
  /* AppearanceChange: of masks, filters, or user data without displacement. A commit then requires no new build. */
  enum Change { InputChange = 1, AppearanceChange = 2 };
  void change(Change change) { changes |= change; }
  /* Commits the geometry. The next commit of a scene builds it if necessary. */
  void commit();
  void setEnabled(bool enabled) { isEnabled = enabled; }
  void setUserData(void* userData);

  SubstituteData* const data;
  const RTCGeometry substitute;

  /* Builds the surface if needsBuild(). Returns false if `progress` canceled. Threads may call it concurrently. */
  bool build(const Progress& progress);
  bool needsBuild() const { return isCommitted && isEnabled; }

  /* True if scenes must contain the original. Only build() changes this. */
  bool isLeftToEmbree() const { return isLeft; }

private:
  Substituted(const std::string& settings, RTCGeometry original, RTCGeometryType type, SubstituteData* data,
              RTCGeometry substitute);
  void discard(); // releases the built surface and its group
  void buildSurface(const Progress& progress);

  const std::string settings;
  std::mutex building;
  CbvhSurface surface = nullptr;
  unsigned int changes = InputChange;
  // atomic: scenes with this geometry may be committed concurrently
  std::atomic<bool> isCommitted{false}, isEnabled{true}, isLeft{false};
};

} // namespace interposer
