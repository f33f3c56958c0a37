// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Runs a viewer's background work, one task at a time: loading a model, or building a scene. All functions except
 * progress must be called from the same thread. */

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

  /* Stops the current task. */
  ~Worker();

  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /* Sends phases to progress() instead of stderr, which then only shows tasks that were stopped. */
  void reportProgress();

  /* Starts a task. `name` is for progress(). There must be no current task. */
  void start(const std::string& name, std::function<void()> work);

  /* True until take() is called, even after the task has ended. */
  bool busy() const { return task.valid(); }

  /* Makes the current task end early, and take() throw Canceled. Does nothing without a task. */
  void cancel();

  bool finished() const;
  void wait() const { task.wait(); }

  /* Waits for the task and rethrows its exception. */
  void take();

  /* Cancels the current task, if there is one, and waits until it has ended. */
  void stop();

  struct Progress
  {
    std::string work;
    std::string phase;   // empty if the task reports no progress
    double fraction = 0; // of the phase that is done, in [0,1]
  };

  /* Returns nothing without a task. */
  std::optional<Progress> progress() const;

private:
  void setPhase(const std::string& phase, double fraction);

  std::future<void> task;
  std::string name;
  bool listening = false, cancelled = false;

  mutable std::mutex mutex; // protects the members below
  std::string phase;
  double fraction = 0;
};

} // namespace cbvh
