// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A function missing here would be resolved to the program's own library. tests/programs/bench_cli.sh detects that. */

#include "embree_calls.h"
#include "basics/error.h"

#include <cstddef>
#include <dlfcn.h>
#include <iterator>
#include <utility>

/* Jumps to the address in a slot and preserves argument registers. */
#if defined(__x86_64__)
#define CBVH_JUMP(slot) "jmp *" slot "(%rip)\n"
#elif defined(__aarch64__)
#define CBVH_JUMP(slot) "adrp x16, " slot "\nldr x16, [x16, #:lo12:" slot "]\nbr x16\n"
#else
#error "jumping through a slot is implemented for x86-64 and ARM64 only"
#endif

// clang-format off
#define CBVH_EMBREE_FUNCTIONS(EACH) \
  EACH(rtcNewDevice) EACH(rtcReleaseDevice) EACH(rtcGetDeviceError) EACH(rtcGetDeviceProperty) \
  EACH(rtcSetDeviceErrorFunction) EACH(rtcSetDeviceMemoryMonitorFunction) \
  EACH(rtcNewBuffer) EACH(rtcReleaseBuffer) EACH(rtcGetBufferData) \
  EACH(rtcNewGeometry) EACH(rtcReleaseGeometry) EACH(rtcCommitGeometry) \
  EACH(rtcSetGeometryBuffer) EACH(rtcSetNewGeometryBuffer) EACH(rtcSetGeometryUserData) \
  EACH(rtcSetGeometrySubdivisionMode) EACH(rtcSetGeometryTessellationRate) EACH(rtcSetGeometryTimeStepCount) \
  EACH(rtcSetGeometryDisplacementFunction) EACH(rtcSetGeometryCompression) EACH(rtcInterpolateN) \
  EACH(rtcNewScene) EACH(rtcReleaseScene) EACH(rtcAttachGeometry) EACH(rtcCommitScene) \
  EACH(rtcSetSceneFlags) EACH(rtcSetSceneProgressMonitorFunction) \
  EACH(rtcGetSceneBounds) EACH(rtcGetSceneCompressionStatistics) \
  EACH(rtcIntersect1) EACH(rtcIntersect4) EACH(rtcIntersect8) EACH(rtcIntersect16) EACH(rtcIntersect1M) \
  EACH(rtcOccluded1) EACH(rtcOccluded4) EACH(rtcOccluded8) EACH(rtcOccluded16) EACH(rtcOccluded1M)
// clang-format on

/* A slot, and the function that jumps to its contents with any arguments. */
#define CBVH_FUNCTION(name) \
  extern "C" void* cbvh_slot_##name; \
  void* cbvh_slot_##name = nullptr; \
  asm(".pushsection .text\n" \
      ".balign 16\n" \
      ".globl " #name "\n" \
      ".type " #name ", %function\n" #name ": " CBVH_JUMP("cbvh_slot_" #name) ".size " #name ", . - " #name "\n" \
                                                                              ".popsection\n");
CBVH_EMBREE_FUNCTIONS(CBVH_FUNCTION)

namespace programs {
namespace {

struct Slot {
  const char* name;
  void** function;
};

#define CBVH_SLOT(name) {#name, &cbvh_slot_##name},
constexpr Slot slots[] = {CBVH_EMBREE_FUNCTIONS(CBVH_SLOT)};

std::string currentLibrary;

/* Called instead of a function that the library lacks. */
template<size_t slot>
[[noreturn]] void missingFunction() {
  throw Error(currentLibrary + " has no " + slots[slot].name + ": expected a library with this function");
}

template<size_t... i>
void fill(const EmbreeFunctions& functions, std::index_sequence<i...>) {
  const auto valueOf = [&](size_t slot, void (*fallback)()) {
    void* const function = functions.at(slots[slot].name);
    return function ? function : reinterpret_cast<void*>(fallback);
  };
  ((*slots[i].function = valueOf(i, missingFunction<i>)), ...);
}

} // namespace

EmbreeFunctions embreeFunctionsOf(void* opened) {
  EmbreeFunctions functions;
  for (const Slot& slot : slots) functions[slot.name] = dlsym(opened, slot.name);
  return functions;
}

void useEmbreeFunctions(const EmbreeFunctions& functions, const std::string& library) {
  currentLibrary = library;
  fill(functions, std::make_index_sequence<std::size(slots)>());
}

} // namespace programs
