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

namespace cbvh::python {
namespace {

constexpr auto patience = std::chrono::milliseconds(50);

std::timed_mutex turn;
std::atomic<std::thread::id> whoseTurn;

/* Threads in runInterruptible, and whether the interpreter is about to end. Both change only under the interpreter's
 * lock. */
std::atomic<int> inside{0};
std::atomic<bool> ending{false};

/* Counts the calling thread, unless the interpreter is about to end: a daemon thread that then waits for the
 * interpreter's lock is unwound through destructors, which ends the process by std::terminate. */
class Inside
{
public:
  Inside()
  {
    if (ending)
      throw Canceled();
    inside++;
  }
  ~Inside() { inside--; }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;
};

void throwIfSignalled()
{
  if (PyErr_CheckSignals())
    throw py::error_already_set();
}

std::unique_lock<std::timed_mutex> takeTurn()
{
  if (whoseTurn == std::this_thread::get_id())
    throw std::runtime_error("progress cannot build or trace, because its own build or trace is running");
  std::unique_lock<std::timed_mutex> lock(turn, std::defer_lock);
  for (;;)
  {
    {
      const py::gil_scoped_release released;
      if (lock.try_lock_for(patience))
        break;
    }
    if (ending)
      throw Canceled();
    throwIfSignalled();
  }
  whoseTurn = std::this_thread::get_id();
  return lock;
}

class Task
{
public:
  explicit Task(const std::function<void()>& work)
  {
    setPhaseListener([this](const std::string& name, double fraction) { addNews(name, fraction); });
    worker = std::thread([this, work] {
      try
      {
        work();
      }
      catch (...)
      {
        failure = std::current_exception();
      }
      const std::lock_guard<std::mutex> lock(mutex);
      done = true;
      changed.notify_one();
    });
  }

  /* Cancels unfinished work. Requires the interpreter's lock. */
  ~Task()
  {
    if (worker.joinable())
    {
      requestCancel();
      join();
    }
    clearCancel();
    setPhaseListener(nullptr);
    whoseTurn = std::thread::id();
  }

  void wait(const py::object& progress)
  {
    for (bool ended = false; !ended;)
    {
      std::deque<News> received;
      {
        const py::gil_scoped_release released;
        std::unique_lock<std::mutex> lock(mutex);
        changed.wait_for(lock, patience, [&] { return done || !news.empty(); });
        received.swap(news);
        ended = done;
      }
      throwIfSignalled();
      if (!progress.is_none())
        for (const News& n : received)
          progress(n.name, n.fraction);
    }
    join();
    if (failure)
      std::rethrow_exception(failure);
  }

private:
  struct News
  {
    std::string name;
    double fraction = 0;
  };

  void addNews(const std::string& name, double fraction)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    if (name == last.name && fraction == last.fraction)
      return; // a phase may end at its last percentage
    last = {name, fraction};
    news.push_back(last);
    changed.notify_one();
  }

  void join()
  {
    const py::gil_scoped_release released;
    worker.join();
  }

  std::mutex mutex;
  std::condition_variable changed;
  std::deque<News> news; // not yet passed to `progress`
  News last;
  bool done = false;
  std::exception_ptr failure;
  std::thread worker;
};

} // namespace

void runInterruptible(const py::object& progress, const std::function<void()>& work)
{
  if (!progress.is_none() && !PyCallable_Check(progress.ptr()))
    throw py::type_error("progress: is not callable: expected None or a callable");
  const Inside counted;
  const std::unique_lock<std::timed_mutex> mine = takeTurn();
  Task(work).wait(progress);
}

bool interpreterEnds() { return ending; }

void cancelAllAtExit()
{
  ending = true;
  while (inside > 0)
  {
    requestCancel(); // a task that ends clears the request
    const py::gil_scoped_release released;
    std::this_thread::sleep_for(patience);
  }
}

} // namespace cbvh::python
