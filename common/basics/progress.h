// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Progress of long runs on stderr, and cancellation by the user. */

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>

namespace cbvh {

/* Makes the first Ctrl-C (SIGINT) or SIGTERM request cancellation. The second signal ends the process. */
void installCancelHandler();

/* True after such a signal. The process must end soon. */
bool interrupted();

/* Makes a signal also end the process, 0.25 s later, by _exit with status 130 and a line that starts with `program`.
 * Embree polls for cancellation rarely, and freeing a large scene takes seconds. The unfinished file is removed. Only
 * for programs that need no other cleanup. Requires installCancelHandler. */
void endSoonAfterCancel(const char* program);

/* Sets the file that endSoonAfterCancel removes. Empty for none. */
void setUnfinishedFile(const std::string& path);

/* Requests cancellation, as a signal does. */
void requestCancel();

/* Withdraws requestCancel, for programs that continue. Does not withdraw a signal. */
void clearCancel();

/* True if the running work should stop. Thread-safe. */
bool cancelRequested();

/* Throws Cancelled if cancelRequested(). */
void throwIfCancelled();

/* Receives the name of a phase and the fraction that is done: 0 at the start, 1 at the end of a phase that was not
 * stopped. Called on any thread, but never concurrently. Must not throw. */
using PhaseListener = std::function<void(const std::string& name, double fraction)>;

/* Sends progress to a listener instead of stderr; an empty listener selects stderr again. Must not be called while a
 * phase runs. */
void setPhaseListener(PhaseListener listener);

/* Prints a line per phase: its name, the percentage while it runs if stderr is a terminal, and its time at the end.
 * Only one phase may run at a time. */
class Phase
{
public:
  /* PercentAndTimeLeft is for phases of constant speed. */
  enum Display { Percent, PercentAndTimeLeft };

  explicit Phase(const std::string& name, Display display = Percent);
  ~Phase();

  /* Reports the fraction done, in [0,1]; values below an earlier one are ignored. Thread-safe. */
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

} // namespace cbvh
