// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A geometry of the application that another stands for in scenes. The application's handle is Embree's own geometry, which has all that it was told, and
 * interpolates, but is in no scene: so Embree never tessellates it. */

#include "input.h"
#include "stand_in.h"

#include <atomic>
#include <functional>
#include <mutex>
#include <string>

namespace interposer {

/* Told how much is done, 0 to 1; false cancels. */
typedef std::function<bool(double)> Progress;

class Substituted
{
public:
  /* NULL where there can be none. settings: of the context of libembree_cbvh */
  static Substituted* make(RTCDevice device, const std::string& settings, RTCGeometry original, RTCGeometryType type);
  ~Substituted();
  Substituted(const Substituted&) = delete;
  Substituted& operator=(const Substituted&) = delete;

  /* What a commit takes. */
  Input input;
  /* Of setters: input is to be built again, or is not. */
  enum Change { OfInput = 1, OfLook = 2 };
  void change(Change what) { changes |= what; }
  void commit();
  void setEnabled(bool to) { isEnabled = to; }
  void setUserData(void* userData);

  StandIn* const standIn;
  const RTCGeometry substitute;

  /* Builds what was committed, if that was not done. Returns false where progress said so. */
  bool build(const Progress& progress);
  bool wantsBuild() const { return isCommitted && isEnabled; }

  /* Whether scenes are to have the original; changes in build() alone. */
  bool isLeftToEmbree() const { return isLeft; }

private:
  Substituted(const std::string& settings, RTCGeometry original, RTCGeometryType type, StandIn* standIn, RTCGeometry substitute);
  void discard();
  void buildSurface(const Progress& progress);

  const std::string settings;
  std::mutex building;
  CbvhSurface surface = nullptr;
  unsigned int changes = OfInput;
  std::atomic<bool> isCommitted{false}, isEnabled{true}, isLeft{false};   // several scenes with it may be committed at a time
};

} // namespace interposer
