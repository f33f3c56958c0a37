// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Long work without the interpreter's lock, of which Python hears how far it is, and which Ctrl-C stops.
 *
 * The work runs on a thread of its own that never touches Python. The thread that called waits for it, and between
 * waits takes the interpreter's lock, looks for signals, and calls the user's `progress`; an exception of either
 * (KeyboardInterrupt, or what `progress` throws) cancels the work, and is raised when it has stopped.
 *
 * There is one flag for cancelling in common/, so calls that other threads make meanwhile wait for their turn. */

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <utility>

namespace cbvh::python {

namespace py = pybind11;

/* progress: None, or called with the name of a phase and how much of it is done, 0 to 1. Throws what work throws. */
void runInterruptible(const py::object& progress, const std::function<void()>& work);

/* The same for work that has a result. */
template<typename Work>
auto interruptible(const py::object& progress, const Work& work)
{
  std::optional<decltype(work())> result;
  runInterruptible(progress, [&] { result.emplace(work()); });
  return std::move(*result);
}

/* Cancels the work of all threads and waits until they have left; later calls throw Cancelled. For Python's atexit, which
 * runs before the interpreter ends: daemon threads are not joined before. */
void cancelAllAtExit();
bool interpreterEnds(); // cancelAllAtExit was called

} // namespace cbvh::python
