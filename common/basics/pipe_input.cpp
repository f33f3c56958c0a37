// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/pipe_input.h"
#include "basics/error.h"
#include "basics/progress.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace programs {
namespace {

constexpr std::chrono::seconds longestWait{10}; // for a program that opens the pipe for writing
constexpr std::chrono::milliseconds step{20};   // between two checks for such a program
constexpr int pollMilliseconds = 100;           // an idle read notices cancellation within this time

} // namespace

bool isPipe(const std::string& path) {
  struct stat status;
  return stat(path.c_str(), &status) == 0 && S_ISFIFO(status.st_mode);
}

PipeInput::PipeInput(const std::string& path)
  : path(path),
    file(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
  if (file < 0) throw Error(path + ": cannot be opened: " + std::strerror(errno));
}

PipeInput::~PipeInput() { close(file); }

PipeInput::int_type PipeInput::underflow() {
  const auto start = std::chrono::steady_clock::now();
  for (;;) {
    throwIfCanceled();
    const ssize_t bytes = read(file, buffer.data(), buffer.size());
    if (bytes > 0) {
      hadWriter = true;
      setg(buffer.data(), buffer.data(), buffer.data() + bytes);
      return traits_type::to_int_type(*gptr());
    }
    if (bytes == 0 && hadWriter) return traits_type::eof();
    if (bytes == 0) // no program has the pipe open for writing
    {
      if (std::chrono::steady_clock::now() - start > longestWait)
        throw Error(path + ": cannot read this pipe: no program opened it for writing within " +
                    std::to_string(longestWait.count()) + " seconds");
      std::this_thread::sleep_for(step);
      continue;
    }
    if (errno == EAGAIN) {
      hadWriter = true;
      pollfd waiting{file, POLLIN, 0};
      poll(&waiting, 1, pollMilliseconds);
    } else if (errno != EINTR) throw Error(path + ": read error: " + std::strerror(errno));
  }
}

} // namespace programs
