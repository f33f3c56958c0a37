// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/progress.h"
#include "basics/error.h"

#include <algorithm>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <utility>
#include <sys/time.h>
#include <unistd.h>

namespace programs {
namespace {

volatile std::sig_atomic_t signalFlag = 0;
std::atomic<bool> requestFlag{false};
thread_local const Cancellation* threadCancellation = nullptr;
PhaseListener phaseListener;

/* Read by signal handlers, which must not allocate. */
char cancelMessage[64] = ""; // empty before forceExitAfterCancel
char unfinishedFile[PATH_MAX] = "";

void onSignal(int signal) {
  signalFlag = 1;
  std::signal(signal, SIG_DFL);
  if (!cancelMessage[0]) return;
  constexpr suseconds_t grace = 250000; // microseconds for phases to end by themselves
  const itimerval timer{{0, 0}, {0, grace}};
  setitimer(ITIMER_REAL, &timer, nullptr);
}

void onGracePeriodEnd(int) {
  constexpr int canceledStatus = 130; // 128 + SIGINT, as in shells
  if (unfinishedFile[0]) unlink(unfinishedFile);
  (void)!write(STDERR_FILENO, cancelMessage, std::strlen(cancelMessage));
  _exit(canceledStatus);
}

/* "about 12 min" or "about 40 s"; `fraction` > 0 is done after `seconds`. */
std::string timeLeft(double seconds, double fraction) {
  const double left = seconds / fraction - seconds;
  const bool isShort = left < 90;
  return "about " + std::to_string(int((isShort ? left : left / 60) + 0.5)) + (isShort ? " s" : " min");
}

} // namespace

void installCancelHandler() {
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
}

bool interrupted() { return signalFlag != 0; }

void forceExitAfterCancel(const char* program) {
  std::snprintf(cancelMessage, sizeof(cancelMessage), "\n%s: canceled\n", program);
  std::signal(SIGALRM, onGracePeriodEnd);
}

void setUnfinishedFile(const std::string& path) {
  unfinishedFile[0] = 0; // a handler that runs during the copy sees an empty path
  if (path.empty() || path.size() >= sizeof(unfinishedFile)) return;
  std::memcpy(unfinishedFile + 1, path.c_str() + 1, path.size());
  unfinishedFile[0] = path[0];
}

void requestCancel() { requestFlag = true; }

void clearCancel() { requestFlag = false; }

CancellationScope::CancellationScope(const Cancellation* cancellation) : outer(threadCancellation) {
  threadCancellation = cancellation;
}

CancellationScope::~CancellationScope() { threadCancellation = outer; }

const Cancellation* CancellationScope::current() { return threadCancellation; }

bool cancelRequested() {
  return interrupted() || (threadCancellation ? threadCancellation->isRequested() : requestFlag.load());
}

void throwIfCanceled() {
  if (cancelRequested()) throw Canceled();
}

void setPhaseListener(PhaseListener listener) { phaseListener = std::move(listener); }

Phase::Phase(const std::string& name, Display display)
  : name(name),
    display(display),
    start(std::chrono::steady_clock::now()),
    terminal(isatty(STDERR_FILENO)) {
  throwIfCanceled();
  print(false);
}

Phase::~Phase() { print(true); }

void Phase::update(double fraction) {
  const int now = int(std::min(1.0, fraction) * 100.0);
  std::lock_guard<std::mutex> lock(mutex);
  if (now <= percent) return;
  percent = now;
  print(false);
}

double Phase::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void Phase::print(bool final) {
  const bool stopped = final && (cancelRequested() || std::uncaught_exceptions());
  if (phaseListener) {
    if (!stopped) phaseListener(name, final ? 1.0 : 0.01 * percent);
    return;
  }
  if (!final && !terminal) return;
  const char* back = terminal ? "\r\033[K" : "";
  if (!final) {
    const bool showsTime = display == PercentAndTimeLeft && percent;
    const std::string left = showsTime ? ", " + timeLeft(seconds(), 0.01 * percent) + " left" : "";
    std::fprintf(stderr, "%s  %s %d%%%s", back, name.c_str(), percent, left.c_str());
  } else if (stopped) std::fprintf(stderr, "%s  %s: stopped after %.1f s\n", back, name.c_str(), seconds());
  else std::fprintf(stderr, "%s  %s: %.1f s\n", back, name.c_str(), seconds());
  std::fflush(stderr);
}

} // namespace programs
