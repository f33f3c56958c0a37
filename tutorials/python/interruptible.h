// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Runs long work without the interpreter's lock, reports progress to Python, and lets Ctrl-C cancel it.
 *
 * The work runs on its own thread, which never uses Python. The calling thread waits for it; between waits it acquires
 * the interpreter's lock, checks for signals, and calls the user's `progress`. An exception (KeyboardInterrupt, or one
 * that `progress` raises) cancels the work and is raised after the work has stopped.
 *
 * common/ has only one flag for cancellation, so concurrent calls from other threads wait until it is their turn. */

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <utility>

namespace cbvh::python {

namespace py = pybind11;

/* `progress` is None, or is called with the name of a phase and the fraction done, 0 to 1. Throws what `work`
 * throws. */
void runInterruptible(const py::object& progress, const std::function<void()>& work);

/* The same for work with a result. */
template<typename Work>
auto interruptible(const py::object& progress, const Work& work)
{
  std::optional<decltype(work())> result;
  runInterruptible(progress, [&] { result.emplace(work()); });
  return std::move(*result);
}

/* Cancels the work of all threads and waits until they have left; later calls throw Canceled. For Python's atexit,
 * which runs before the interpreter ends: daemon threads are not joined before. */
void cancelAllAtExit();
bool interpreterEnds(); // true after cancelAllAtExit was called

} // namespace cbvh::python
