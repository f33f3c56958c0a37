// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a long run is doing, on stderr, and how the user stops it. */

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>

namespace cbvh {

/* Makes Ctrl-C (SIGINT) and SIGTERM stop what runs instead of ending the process; the
 * second signal ends it. */
void installCancelHandler();

/* Whether there was such a signal: the process is about to end. */
bool interrupted();

/* Has a signal also end the process, by _exit with status 130 and a line that starts with the
 * program's name, if it is still there a little later: Embree looks at the flag only now and
 * then, and large scenes take seconds to be freed. A PendingFile that is being written is
 * removed. For programs that leave nothing else behind. Follows installCancelHandler. */
void endSoonAfterCancel(const char* program);

/* The file that endSoonAfterCancel removes, empty for none. */
void setUnfinishedFile(const std::string& path);

/* Stops what runs, as a signal does. */
void requestCancel();

/* Takes that back, for a program that goes on after what it stopped; a signal stays. */
void clearCancel();

/* Whether what runs is to stop. Safe in any thread. */
bool cancelRequested();

/* Throws Cancelled if it is. */
void throwIfCancelled();

/* Hears of phases in place of stderr: the name, and how much of it is done, 0 at the start and 1 at the end of a
 * phase that is not stopped. Called by any thread, by one at a time; throws nothing. */
using PhaseListener = std::function<void(const std::string& name, double fraction)>;

/* Empty: stderr again. Called while no phase runs. */
void setPhaseListener(PhaseListener listener);

/* One line a phase: its name, percents while it runs if stderr is a terminal, and
 * its time at the end. Only one phase runs at a time; update may come from any
 * thread. */
class Phase
{
public:
  enum Says { SaysPercents, SaysTimeLeft }; // the latter besides percents, for phases that go at an even speed

  explicit Phase(const std::string& name, Says says = SaysPercents);
  ~Phase();

  /* fraction in [0,1]; smaller ones than before are ignored. */
  void update(double fraction);

  double seconds() const;

private:
  void print(bool final);

  std::string name;
  Says says;
  std::chrono::steady_clock::time_point start;
  bool terminal;
  std::mutex mutex;
  int percent = 0;
};

} // namespace cbvh
