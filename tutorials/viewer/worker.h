// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a viewer does in the background, one thing at a time: reading a model, or building
 * a scene. Everything but progress is called from one thread. */

#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <string>

namespace cbvh {

class Worker
{
public:
  Worker() = default;

  /* Stops what is under way. */
  ~Worker();

  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /* From now on, phases are reported by progress() and not on stderr, which only shows
   * work that was stopped. */
  void listen();

  /* name: of the work, for progress(). Called while nothing is under way. */
  void start(const std::string& name, std::function<void()> work);

  /* Until take() was called, also after the work ended. */
  bool busy() const { return task.valid(); }

  /* Makes the work end early, if there is any, and take() throw Cancelled. */
  void cancel();

  bool finished() const;
  void wait() const { task.wait(); }

  /* Waits for the work, and throws what it threw. */
  void take();

  /* Cancels the work, if there is any, and waits until it has ended. */
  void stop();

  struct Progress
  {
    std::string work;
    std::string phase;   // empty: of nothing that could say how long it takes
    double fraction = 0; // done of the phase, in [0,1]
  };

  /* Nothing while nothing is under way. */
  std::optional<Progress> progress() const;

private:
  void hear(const std::string& phase, double fraction);

  std::future<void> task;
  std::string name;
  bool listening = false, cancelled = false;

  mutable std::mutex mutex; // of what follows
  std::string phase;
  double fraction = 0;
};

} // namespace cbvh
