// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Progress of long runs on stderr, and cancellation by the user. Every function that shows progress may throw
 * Canceled. */

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>

namespace programs {

/* Makes the first Ctrl-C (SIGINT) or SIGTERM request cancellation. A second one of the same kind ends the
 * process. */
void installCancelHandler();

/* True after such a signal: the process must end soon. */
bool interrupted();

/* Makes a signal also end the process after 0.25 s, with status 130 and a line that starts with `program`: Embree
 * polls for cancellation rarely, and freeing a large scene takes seconds. Only removes the unfinished file. Requires
 * installCancelHandler. */
void forceExitAfterCancel(const char* program);

/* Sets the file that forceExitAfterCancel removes; empty for none. */
void setUnfinishedFile(const std::string& path);

void requestCancel();

/* Withdraws requestCancel, but not a signal. */
void clearCancel();

/* A request to cancel the work of some threads only. Thread-safe. */
class Cancellation {
public:
  void request() { flag = true; }
  bool isRequested() const { return flag; }

private:
  std::atomic<bool> flag{false};
};

/* While it lives, `cancellation` replaces requestCancel for the calling thread, unless it is null. Threads that work
 * for this thread need a scope, too: parallelFor makes one. */
class CancellationScope {
public:
  explicit CancellationScope(const Cancellation* cancellation);
  ~CancellationScope();
  CancellationScope(const CancellationScope&) = delete;
  CancellationScope& operator=(const CancellationScope&) = delete;

  /* Of the calling thread, or null. */
  static const Cancellation* current();

private:
  const Cancellation* const outer;
};

/* True after a signal, or a request to cancel the work of the calling thread. Thread-safe. */
bool cancelRequested();

void throwIfCanceled();

/* Receives the name of a phase and the fraction done: 0 at the start, 1 at the end unless the phase was stopped.
 * Called on any thread, but never concurrently. Must not throw. */
using PhaseListener = std::function<void(const std::string& name, double fraction)>;

/* Sends progress to a listener instead of stderr; empty selects stderr again. Must not be called during a phase. */
void setPhaseListener(PhaseListener listener);

/* Prints a line per phase: its name, the percentage if stderr is a terminal, and finally its time. Only one phase
 * may run at a time. */
class Phase {
public:
  /* PercentAndTimeLeft requires a phase of constant speed. */
  enum Display { Percent, PercentAndTimeLeft };

  explicit Phase(const std::string& name, Display display = Percent);
  ~Phase();

  /* `fraction` is in [0,1]; values below an earlier one are ignored. Thread-safe. */
  void update(double fraction);

  double seconds() const;

private:
  void print(bool final);

  std::string name;
  Display display;
  std::chrono::steady_clock::time_point start;
  bool terminal;
  std::mutex mutex;
  int percent = 0;
};

} // namespace programs
