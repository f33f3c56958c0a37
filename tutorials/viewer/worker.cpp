// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "worker.h"
#include "basics/error.h"
#include "basics/progress.h"

#include <chrono>
#include <cstdio>
#include <utility>

namespace programs {

Worker::~Worker() {
  stop();
  if (listening) setPhaseListener({});
}

void Worker::reportProgress() {
  listening = true;
  setPhaseListener([this](const std::string& phase, double fraction) { setPhase(phase, fraction); });
}

void Worker::start(const std::string& what, std::function<void()> work) {
  name = what;
  phase.clear();
  task = std::async(std::launch::async, std::move(work));
}

void Worker::cancel() {
  if (!hasTask()) return;
  cancelled = true;
  requestCancel();
}

bool Worker::finished() const {
  return hasTask() && task.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

void Worker::join() {
  task.wait();
  const bool stopped = cancelled;
  cancelled = false;
  clearCancel();
  std::future<void> done = std::move(task);
  try {
    done.get();
  } catch (const Canceled&) {
    if (listening) // otherwise the phase printed it
      std::fprintf(stderr, "  %s: stopped\n", name.c_str());
    throw;
  } catch (...) {
    if (!stopped) throw;
  }
  if (stopped) throw Canceled(); // discard the result
}

void Worker::stop() {
  if (!hasTask()) return;
  cancel();
  try {
    join();
  } catch (const Canceled&) {}
}

void Worker::setPhase(const std::string& now, double done) {
  std::lock_guard<std::mutex> lock(mutex);
  phase = done < 1.0 ? now : "";
  fraction = done;
}

std::optional<Worker::Progress> Worker::progress() const {
  if (!hasTask()) return std::nullopt;
  if (cancelled) return Progress{"stopping: " + name, "", 0};
  std::lock_guard<std::mutex> lock(mutex);
  return Progress{name, phase, fraction};
}

} // namespace programs
