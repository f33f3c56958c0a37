// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Counts trapped floating-point exceptions, of all threads, and continues after each. x86-64 and Linux only: other
 * processors need not support traps. */

#if defined(__x86_64__) && defined(__linux__)
#define CBVH_FLOAT_TRAPS 1

#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <dlfcn.h>
#include <string>
#include <ucontext.h>
#include <xmmintrin.h>

namespace programs::test {

// While an object exists, signals of trapped exceptions are counted, and the instruction is repeated with the exception
// masked: its result is the same as without traps. The set of exceptions that trap is part of the floating-point state
// of a thread; new threads inherit it. The destructor restores the state of the calling thread.
class FloatTraps {
public:
  FloatTraps() : state(_mm_getcsr()) {
    struct sigaction action = {};
    action.sa_flags = SA_SIGINFO;
    action.sa_sigaction = maskForOneStep;
    sigaction(SIGFPE, &action, &before[0]);
    action.sa_sigaction = restoreAfterStep;
    sigaction(SIGTRAP, &action, &before[1]);
  }
  ~FloatTraps() {
    _mm_setcsr(state);
    sigaction(SIGFPE, &before[0], nullptr);
    sigaction(SIGTRAP, &before[1], nullptr);
  }
  FloatTraps(const FloatTraps&) = delete;
  FloatTraps& operator=(const FloatTraps&) = delete;

  // Returns a line per instruction that trapped since the last call, or an empty string.
  std::string takeReport() {
    std::string report;
    for (unsigned i = 0; i < maxPlaces; i++) {
      Place& place = places[i];
      if (const size_t count = place.count.exchange(0)) {
        const int code = place.code;
        const char* name = code == FPE_FLTDIV   ? "division by zero"
                           : code == FPE_FLTINV ? "invalid operation"
                           : code == FPE_FLTOVF ? "overflow"
                           : code == FPE_FLTUND ? "denormal operand"
                                                : "exception";
        Dl_info info = {};
        dladdr((const void*)place.address.load(), &info);
        char line[512];
        std::snprintf(line, sizeof(line), "%zu times %s at %#zx of %s\n", count, name,
                      place.address - size_t(info.dli_fbase), info.dli_fname ? info.dli_fname : "?");
        report += line;
      }
      place.address = 0;
    }
    return report;
  }

private:
  static constexpr unsigned maxPlaces = 64;    // distinct instructions
  static constexpr uint32_t allMasks = 0x1F80; // of MXCSR
  static constexpr greg_t trapFlag = 0x100;    // of EFLAGS: a signal after the next instruction
  struct Place {
    std::atomic<size_t> address, count;
    std::atomic<int> code;
  };

  static void maskForOneStep(int, siginfo_t* info, void* context) {
    ucontext_t& thread = *(ucontext_t*)context;
    for (Place& place : places) {
      size_t address = 0;
      if (!place.address.compare_exchange_strong(address, size_t(info->si_addr)) && address != size_t(info->si_addr))
        continue;
      place.code = info->si_code;
      place.count++;
      break;
    }
    masks = thread.uc_mcontext.fpregs->mxcsr & allMasks;
    thread.uc_mcontext.fpregs->mxcsr |= allMasks;
    thread.uc_mcontext.gregs[REG_EFL] |= trapFlag;
  }
  static void restoreAfterStep(int, siginfo_t*, void* context) {
    ucontext_t& thread = *(ucontext_t*)context;
    thread.uc_mcontext.fpregs->mxcsr = (thread.uc_mcontext.fpregs->mxcsr & ~(allMasks | 0x3F)) | masks;
    thread.uc_mcontext.gregs[REG_EFL] &= ~trapFlag;
  }

  static inline Place places[maxPlaces];
  static inline thread_local volatile uint32_t masks = 0; // of the instruction that is repeated

  const unsigned state;
  struct sigaction before[2];
};

} // namespace programs::test

#endif
