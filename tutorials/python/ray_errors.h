// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Errors of rays and of point queries that several threads trace in one scene. */

#include "basics/error.h"
#include "basics/progress.h"
#include "building/saved_scene.h"
#include "building/traced_scene.h"

#include <mutex>
#include <string>

namespace programs::python {

class RayErrors {
public:
  /* Call it after tracing. Throws Error if rays reached damaged blocks of the file, in this call or in an earlier one:
   * the library reports the first such block only, to any of the threads. Throws Canceled. */
  void check(const TracedScene& scene) const {
    throwIfCanceled(); // before the scene forgets an error
    const std::lock_guard<std::mutex> lock(mutex);
    if (!damage.empty()) throw Error(damage);
    try {
      scene.check();
    } catch (const Error& error) {
      if (dynamic_cast<const SavedScene*>(&scene)) damage = error.what();
      throw;
    }
  }

private:
  mutable std::mutex mutex; // protects the member below
  mutable std::string damage;
};

} // namespace programs::python
