// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Runs long work without the interpreter's lock, with progress and Ctrl-C.
 *
 * The work has its own thread, which never uses Python. The calling thread waits, from time to time checks for signals
 * under the interpreter's lock, and calls `progress`. An exception (KeyboardInterrupt, or one of `progress`) cancels
 * the work and is raised once it has stopped.
 *
 * common/ has only one flag for cancellation, so concurrent calls run one after the other. */

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <utility>

namespace programs::python {

namespace py = pybind11;

/* `progress` is None, or receives the name of a phase and the fraction done, 0 to 1. Throws what `work` throws. */
void runInterruptible(const py::object& progress, const std::function<void()>& work);

template<typename Work>
auto interruptible(const py::object& progress, const Work& work) {
  std::optional<decltype(work())> result;
  runInterruptible(progress, [&] { result.emplace(work()); });
  return std::move(*result);
}

/* Cancels the work of all threads and waits for it; later calls throw Canceled. For Python's atexit, because daemon
 * threads are not joined before the interpreter ends. */
void cancelAllAtExit();
bool interpreterEnds(); // after cancelAllAtExit

} // namespace programs::python
