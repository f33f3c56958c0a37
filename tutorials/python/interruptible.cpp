// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "interruptible.h"
#include "basics/error.h"
#include "basics/progress.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <set>
#include <string>
#include <thread>

namespace programs::python {
namespace {

constexpr auto pollInterval = std::chrono::milliseconds(50);

void throwIfSignalled() {
  if (PyErr_CheckSignals()) throw py::error_already_set();
}

/* --- calls that have not returned; both variables are used only under the interpreter's lock ---------- */

class RunningCall;
std::set<RunningCall*> runningCalls;
bool ending = false; // the interpreter is about to end

/* Registers the calling thread, unless the interpreter is about to end: a daemon thread that then waits for the
 * interpreter's lock is unwound through destructors, which ends the process by std::terminate. */
class RunningCall {
public:
  RunningCall() {
    if (ending) throw Canceled();
    runningCalls.insert(this);
  }
  virtual ~RunningCall() { runningCalls.erase(this); }
  RunningCall(const RunningCall&) = delete;
  RunningCall& operator=(const RunningCall&) = delete;

  virtual void cancel() = 0;
};

/* --- a thread for the work of a call -------------------------------------------------------------------- */

class Task {
public:
  explicit Task(RunningCall& call) : call(call) {}

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
    if (!worker.joinable()) return;
    call.cancel();
    join();
  }

  void addEvent(const std::string& name, double fraction) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (name == last.name && fraction == last.fraction) return; // a phase may end at its last percentage
    last = {name, fraction};
    events.push_back(last);
    changed.notify_one();
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

  void join() {
    const py::gil_scoped_release released;
    worker.join();
  }

  RunningCall& call;
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Event> events; // not yet passed to `progress`
  Event last;
  bool done = false;
  std::exception_ptr failure;
  std::thread worker;
};

/* --- builds ------------------------------------------------------------------------------------------------ */

std::timed_mutex buildMutex;
std::thread::id buildingThread; // the Python thread; used only under the interpreter's lock

class BuildCall : public RunningCall {
public:
  BuildCall() : lock(lockBuilds()) { buildingThread = std::this_thread::get_id(); }

  ~BuildCall() override {
    clearCancel();
    setPhaseListener(nullptr);
    buildingThread = std::thread::id();
  }

  void cancel() override { requestCancel(); }

private:
  static std::unique_lock<std::timed_mutex> lockBuilds() {
    if (buildingThread == std::this_thread::get_id())
      throw std::runtime_error("progress cannot build, because its own build is running");
    std::unique_lock<std::timed_mutex> lock(buildMutex, std::defer_lock);
    for (;;) {
      {
        const py::gil_scoped_release released;
        if (lock.try_lock_for(pollInterval)) break;
      }
      if (ending) throw Canceled();
      throwIfSignalled();
    }
    return lock;
  }

  const std::unique_lock<std::timed_mutex> lock;
};

/* --- queries ------------------------------------------------------------------------------------------------ */

class QueryCall : public RunningCall {
public:
  void cancel() override { cancellation.request(); }

  Cancellation cancellation;
};

} // namespace

void runBuild(const py::object& progress, const std::function<void()>& work) {
  if (!progress.is_none() && !PyCallable_Check(progress.ptr()))
    throw py::type_error("progress: is not callable: expected None or a callable");
  BuildCall call;
  Task task(call);
  setPhaseListener([&](const std::string& name, double fraction) { task.addEvent(name, fraction); });
  task.start(work);
  task.wait(progress);
}

void runQuery(const std::function<void()>& work) {
  QueryCall call;
  Task task(call);
  const std::function<void()> cancelable = [&] {
    const CancellationScope scope(&call.cancellation);
    work();
  };
  task.start(cancelable);
  task.wait(py::none());
}

void runQuery(size_t items, size_t perTask, unsigned threads, const std::function<void(unsigned threads)>& work) {
  if (items > perTask) {
    const size_t tasks = (items + perTask - 1) / perTask;
    runQuery([&] { work(unsigned(std::min(tasks, size_t(threads)))); });
    return;
  }
  {
    QueryCall call;
    const CancellationScope scope(&call.cancellation);
    const py::gil_scoped_release released;
    work(1);
  }
  throwIfSignalled();
}

bool interpreterEnds() { return ending; }

void cancelAllAtExit() {
  ending = true;
  while (!runningCalls.empty()) {
    for (RunningCall* call : runningCalls) call->cancel();
    const py::gil_scoped_release released;
    std::this_thread::sleep_for(pollInterval);
  }
}

} // namespace programs::python
