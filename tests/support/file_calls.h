// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Replaces calls of the C library: the loader finds the program's symbols before libc's. Only one file of a program may
 * include this header. */

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <sys/syscall.h>
#include <unistd.h>

namespace programs::test {

// write() stores this many bytes in all, and kills the process when more follow; never if negative
inline std::atomic<long> bytesUntilKill{-1};
inline std::atomic<int> fsyncError{0};       // of each call; 0: the call is made
inline std::atomic<unsigned> renameDelay{0}; // microseconds
inline std::atomic<unsigned> renameCalls{0};

} // namespace programs::test

extern "C" ssize_t write(int file, const void* data, size_t bytes) {
  using programs::test::bytesUntilKill;
  if (bytesUntilKill >= 0 && long(bytes) > bytesUntilKill) {
    (void)!syscall(SYS_write, file, data, size_t(bytesUntilKill));
    raise(SIGKILL);
  }
  if (bytesUntilKill >= 0) bytesUntilKill -= long(bytes);
  return syscall(SYS_write, file, data, bytes);
}

extern "C" int fsync(int file) {
  errno = programs::test::fsyncError;
  return errno != 0 ? -1 : int(syscall(SYS_fsync, file));
}

extern "C" int rename(const char* from, const char* to) noexcept {
  programs::test::renameCalls++;
  usleep(programs::test::renameDelay);
  return int(syscall(SYS_renameat, -100 /* AT_FDCWD */, from, -100, to));
}
