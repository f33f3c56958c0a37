// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Runs long work without the interpreter's lock, so that other Python threads run meanwhile and Ctrl-C stops it.
 *
 * The work has its own thread, which never uses Python. The calling thread waits, and from time to time checks for
 * signals under the interpreter's lock. An exception (KeyboardInterrupt, or one of `progress`) cancels the work and is
 * raised once it has stopped.
 *
 * Builds use requestCancel and one listener for phases, both of the whole process, because Embree's threads work for
 * them: concurrent builds run one after the other. Each query has a Cancellation of its own: queries run concurrently,
 * also with a build. Queries must not use Phase, and must not use threads of Embree. */

#include <pybind11/pybind11.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <utility>

namespace programs::python {

namespace py = pybind11;

/* Throw what `work` throws. `progress` is None, or receives the name of a phase and the fraction done, 0 to 1. */
void runBuild(const py::object& progress, const std::function<void()>& work);
void runQuery(const std::function<void()>& work);

/* The same for `items` independent rays or points. A single task of `perTask` items, which takes milliseconds, runs on
 * the calling thread, as starting a thread would take longer than tracing a few rays: Ctrl-C is noticed after it.
 * `work` receives the number of useful threads, at most `threads`. */
void runQuery(size_t items, size_t perTask, unsigned threads, const std::function<void(unsigned threads)>& work);

/* The same for work that returns a result. */
template<typename Work>
auto interruptibleBuild(const py::object& progress, const Work& work) {
  std::optional<decltype(work())> result;
  runBuild(progress, [&] { result.emplace(work()); });
  return std::move(*result);
}

template<typename Work>
auto interruptibleQuery(const Work& work) {
  std::optional<decltype(work())> result;
  runQuery([&] { result.emplace(work()); });
  return std::move(*result);
}

/* Cancels the work of all threads and waits for it; later calls throw Canceled. For Python's atexit, because daemon
 * threads are not joined before the interpreter ends. */
void cancelAllAtExit();
bool interpreterEnds(); // after cancelAllAtExit

} // namespace programs::python
