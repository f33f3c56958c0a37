// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Runs one background task at a time. Call all functions on one thread. */

#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <string>

namespace programs {

class Worker {
public:
  Worker() = default;

  ~Worker();

  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /* Sends phases to progress() instead of stderr, which then only shows stopped tasks. */
  void reportProgress();

  /* `name` is for progress(). Requires that there is no task. */
  void start(const std::string& name, std::function<void()> work);

  /* True until join(), even after the task has ended. */
  bool hasTask() const { return task.valid(); }

  /* The task then ends early, and join() throws Canceled. Does nothing without a task. */
  void cancel();

  bool finished() const;
  void wait() const { task.wait(); }

  /* Waits, and rethrows the task's exception. */
  void join();

  /* Cancels the task, if any, and waits for its end. */
  void stop();

  struct Progress {
    std::string work;
    std::string phase;   // may be empty
    double fraction = 0; // of the phase, in [0,1]
  };

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

} // namespace programs
