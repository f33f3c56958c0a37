// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <sys/wait.h>
#include <unistd.h>

namespace programs::test {

// Runs the closure in a child process, which a signal may end. Returns its status as waitpid does.
template<typename Closure>
int statusOfChild(const Closure& closure) {
  const pid_t child = fork();
  if (child == 0) _exit(closure());
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

} // namespace programs::test
