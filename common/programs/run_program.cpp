// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "programs/run_program.h"
#include "basics/error.h"
#include "basics/file_output.h"

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

namespace programs {

int runProgram(const char* name, const std::function<int()>& run) {
  std::signal(SIGXFSZ, SIG_IGN); // writes beyond a file size limit then fail
  try {
    const int status = run();
    writeStandardOutput(""); // reports errors of unchecked output
    return status;
  } catch (const Canceled&) {
    std::fprintf(stderr, "%s: canceled\n", name);
    removeEmptyOutputFolders();
    return 130;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: out of memory\n", name);
  } catch (const std::exception& e) { std::fprintf(stderr, "%s: %s\n", name, e.what()); }
  removeEmptyOutputFolders();
  return 1;
}

} // namespace programs
