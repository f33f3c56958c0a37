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

namespace cbvh {
namespace {

volatile std::sig_atomic_t signalFlag = 0;
std::atomic<bool> requestFlag{false};
PhaseListener phaseListener;

/* What the handlers read, which may allocate nothing. */
char lastWords[64] = "";           // of endSoonAfterCancel, empty without it
char unfinishedFile[PATH_MAX] = ""; // likewise

void onSignal(int signal)
{
  signalFlag = 1;
  std::signal(signal, SIG_DFL);
  if (!lastWords[0])
    return;
  constexpr suseconds_t grace = 250000; // microseconds for phases to end by themselves
  const itimerval timer{{0, 0}, {0, grace}};
  setitimer(ITIMER_REAL, &timer, nullptr);
}

void onGraceOver(int)
{
  constexpr int cancelledStatus = 130; // as a shell has it: 128 + SIGINT
  if (unfinishedFile[0])
    unlink(unfinishedFile);
  (void)!write(STDERR_FILENO, lastWords, std::strlen(lastWords));
  _exit(cancelledStatus);
}

/* "about 12 min" or "about 40 s", of what is left after that time. fraction: that is done, above 0. */
std::string timeLeft(double seconds, double fraction)
{
  const double left = seconds / fraction - seconds;
  return left < 90 ? "about " + std::to_string(int(left + 0.5)) + " s" : "about " + std::to_string(int(left / 60 + 0.5)) + " min";
}

} // namespace

void installCancelHandler()
{
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
}

bool interrupted()
{
  return signalFlag != 0;
}

void endSoonAfterCancel(const char* program)
{
  std::snprintf(lastWords, sizeof(lastWords), "\n%s: cancelled\n", program);
  std::signal(SIGALRM, onGraceOver);
}

void setUnfinishedFile(const std::string& path)
{
  unfinishedFile[0] = 0; // while the rest changes
  if (path.empty() || path.size() >= sizeof(unfinishedFile))
    return;
  std::memcpy(unfinishedFile + 1, path.c_str() + 1, path.size());
  unfinishedFile[0] = path[0];
}

void requestCancel()
{
  requestFlag = true;
}

void clearCancel()
{
  requestFlag = false;
}

bool cancelRequested()
{
  return interrupted() || requestFlag;
}

void throwIfCancelled()
{
  if (cancelRequested())
    throw Cancelled();
}

void setPhaseListener(PhaseListener listener)
{
  phaseListener = std::move(listener);
}

Phase::Phase(const std::string& name, Says says)
  : name(name), says(says), start(std::chrono::steady_clock::now()), terminal(isatty(STDERR_FILENO))
{
  throwIfCancelled();
  print(false);
}

Phase::~Phase()
{
  print(true);
}

void Phase::update(double fraction)
{
  const int now = int(std::min(1.0, fraction) * 100.0);
  std::lock_guard<std::mutex> lock(mutex);
  if (now <= percent)
    return;
  percent = now;
  print(false);
}

double Phase::seconds() const
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void Phase::print(bool final)
{
  const bool stopped = final && (cancelRequested() || std::uncaught_exceptions());
  if (phaseListener)
  {
    if (!stopped)
      phaseListener(name, final ? 1.0 : 0.01 * percent);
    return;
  }
  if (!final && !terminal)
    return;
  const char* back = terminal ? "\r\033[K" : "";
  if (!final)
    std::fprintf(stderr, "%s  %s %d%%%s", back, name.c_str(), percent,
                 says == SaysTimeLeft && percent ? (", " + timeLeft(seconds(), 0.01 * percent) + " left").c_str() : "");
  else if (stopped)
    std::fprintf(stderr, "%s  %s: stopped after %.1f s\n", back, name.c_str(), seconds());
  else
    std::fprintf(stderr, "%s  %s: %.1f s\n", back, name.c_str(), seconds());
  std::fflush(stderr);
}

} // namespace cbvh
