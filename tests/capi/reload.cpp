// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Loads, uses in two threads and unloads libembree_cbvh repeatedly, in a program with its own Embree: memory must not
 * grow. reload PATH/TO/libembree_cbvh.so.1 */

#include "host.h"

#include <dlfcn.h>

#include <fstream>
#include <string>
#include <thread>

using namespace host;

namespace {

size_t residentKiB() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (word == "VmRSS:") {
      size_t n = 0;
      status >> n;
      return n;
    }
  return 0;
}

#define FUNCTION(name) \
  const auto name = (decltype(&::name))dlsym(library, #name); \
  CHECK(name != nullptr); \
  if (!name) return

void use(const char* path) {
  void* const library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    std::fprintf(stderr, "%s\n", dlerror());
    failures++;
    return;
  }
  FUNCTION(cbvhNewContext);
  FUNCTION(cbvhNewSurface);
  FUNCTION(cbvhSetSurfaceCage);
  FUNCTION(cbvhCommitSurface);
  FUNCTION(cbvhNewGroup);
  FUNCTION(cbvhCommitGroup);
  FUNCTION(cbvhIntersect1);
  FUNCTION(cbvhReleaseSurface);
  FUNCTION(cbvhReleaseGroup);
  FUNCTION(cbvhReleaseContext);
  CHECK(dlsym(library, "rtcNewDevice") == nullptr || dlsym(library, "rtcNewDevice") == (void*)rtcNewDevice);
  CbvhContext context = nullptr;
  CbvhSurface surface = nullptr;
  CbvhGroup group = nullptr;
  CHECK(cbvhNewContext("threads=2", nullptr, nullptr, &context) == CBVH_OK);
  const Cube cube;
  const CbvhCage cage = cube.cage(64);
  CHECK(cbvhNewSurface(context, &surface) == CBVH_OK);
  CHECK(cbvhSetSurfaceCage(surface, &cage) == CBVH_OK);
  CHECK(cbvhCommitSurface(surface, nullptr, nullptr) == CBVH_OK);
  CHECK(cbvhNewGroup(context, &surface, 1, &group) == CBVH_OK);
  CHECK(cbvhCommitGroup(group) == CBVH_OK);
  const auto trace = [&] {
    RTCRayHit ray = makeRay({0.1f, 0.2f, 5}, {0, 0, -1});
    CHECK(cbvhIntersect1(group, (CbvhRayHit*)&ray, nullptr));
  };
  trace();
  std::thread(trace).join();
  cbvhReleaseGroup(group);
  cbvhReleaseSurface(surface);
  cbvhReleaseContext(context);
  CHECK(dlclose(library) == 0);
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "reload LIBRARY\n");
    return 1;
  }
  RTCDevice device = rtcNewDevice(nullptr);
  size_t early = 0;
  for (int i = 0; i < 60; i++) {
    use(argv[1]);
    if (i == 19) early = residentKiB();
  }
  CHECK(residentKiB() < early + 4096);
  rtcReleaseDevice(device);
  std::printf("%zu KiB after 20 rounds, %zu after 60\n", early, residentKiB());
  return conclude("unloading");
}
