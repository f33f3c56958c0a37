// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "interruptible.h"
#include "basics/error.h"
#include "basics/progress.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <string>
#include <thread>

namespace programs::python {
namespace {

constexpr auto pollInterval = std::chrono::milliseconds(50);

std::timed_mutex callMutex;
std::atomic<std::thread::id> currentThread;

/* Threads in runInterruptible, and whether the interpreter is about to end. Both change only under the interpreter's
 * lock. */
std::atomic<int> numRunning{0};
std::atomic<bool> ending{false};

/* Counts the calling thread, unless the interpreter is about to end: a daemon thread that then waits for the
 * interpreter's lock is unwound through destructors, which ends the process by std::terminate. */
class RunningCall {
public:
  RunningCall() {
    if (ending) throw Canceled();
    numRunning++;
  }
  ~RunningCall() { numRunning--; }
  RunningCall(const RunningCall&) = delete;
  RunningCall& operator=(const RunningCall&) = delete;
};

void throwIfSignalled() {
  if (PyErr_CheckSignals()) throw py::error_already_set();
}

std::unique_lock<std::timed_mutex> lockCalls() {
  if (currentThread == std::this_thread::get_id())
    throw std::runtime_error("progress cannot build or trace, because its own build or trace is running");
  std::unique_lock<std::timed_mutex> lock(callMutex, std::defer_lock);
  for (;;) {
    {
      const py::gil_scoped_release released;
      if (lock.try_lock_for(pollInterval)) break;
    }
    if (ending) throw Canceled();
    throwIfSignalled();
  }
  currentThread = std::this_thread::get_id();
  return lock;
}

class Task {
public:
  Task() {
    setPhaseListener([this](const std::string& name, double fraction) { addEvent(name, fraction); });
  }

  /* Separate from the constructor: the destructor must also run if the system refuses the thread. */
  void start(const std::function<void()>& work) {
    worker = std::thread([this, &work] {
      try {
        work();
      } catch (...) { failure = std::current_exception(); }
      const std::lock_guard<std::mutex> lock(mutex);
      done = true;
      changed.notify_one();
    });
  }

  /* Cancels unfinished work. Requires the interpreter's lock. */
  ~Task() {
    if (worker.joinable()) {
      requestCancel();
      join();
    }
    clearCancel();
    setPhaseListener(nullptr);
    currentThread = std::thread::id();
  }

  void wait(const py::object& progress) {
    for (bool ended = false; !ended;) {
      std::deque<Event> received;
      {
        const py::gil_scoped_release released;
        std::unique_lock<std::mutex> lock(mutex);
        changed.wait_for(lock, pollInterval, [&] { return done || !events.empty(); });
        received.swap(events);
        ended = done;
      }
      throwIfSignalled();
      if (!progress.is_none())
        for (const Event& n : received) progress(n.name, n.fraction);
    }
    join();
    if (failure) std::rethrow_exception(failure);
  }

private:
  struct Event {
    std::string name;
    double fraction = 0;
  };

  void addEvent(const std::string& name, double fraction) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (name == last.name && fraction == last.fraction) return; // a phase may end at its last percentage
    last = {name, fraction};
    events.push_back(last);
    changed.notify_one();
  }

  void join() {
    const py::gil_scoped_release released;
    worker.join();
  }

  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Event> events; // not yet passed to `progress`
  Event last;
  bool done = false;
  std::exception_ptr failure;
  std::thread worker;
};

} // namespace

void runInterruptible(const py::object& progress, const std::function<void()>& work) {
  if (!progress.is_none() && !PyCallable_Check(progress.ptr()))
    throw py::type_error("progress: is not callable: expected None or a callable");
  const RunningCall counted;
  const std::unique_lock<std::timed_mutex> lock = lockCalls();
  Task task;
  task.start(work);
  task.wait(progress);
}

bool interpreterEnds() { return ending; }

void cancelAllAtExit() {
  ending = true;
  while (numRunning > 0) {
    requestCancel(); // a task that ends clears the request
    const py::gil_scoped_release released;
    std::this_thread::sleep_for(pollInterval);
  }
}

} // namespace programs::python
