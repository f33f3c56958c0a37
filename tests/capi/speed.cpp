// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays per second of one thread on a displaced cube: through the user geometry of the surrounding Embree, by
 * libembree_cbvh's own functions, on Embree's subdivision surface, and from a file. Prints medians of interleaved runs.
 * capi_speed [--rays N] [--rate R] [--turns N] */

#include "host.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <unistd.h>

using namespace host;

namespace {

double secondsOf(const std::function<void()>& run) {
  const auto start = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// Traced alternately with others, with the same rays.
struct Contender {
  const char* name;
  std::function<void(std::vector<RTCRayHit>&)> trace;
  std::vector<double> seconds;
};

template<unsigned N>
void inPackets(RTCScene scene, std::vector<RTCRayHit>& rays) {
  alignas(64) int valid[N];
  std::fill(valid, valid + N, -1);
  for (size_t first = 0; first + N <= rays.size(); first += N) {
    typename Packet<N>::RayHits packet;
    for (unsigned i = 0; i < N; i++) setRay(&packet, N, i, rays[first + i]);
    intersect(valid, scene, packet);
  }
}

void measure(const char* what, const std::vector<RTCRayHit>& rays, std::vector<Contender> contenders, unsigned turns,
             bool isOfFirst = false) {
  for (unsigned turn = 0; turn < turns; turn++)
    for (Contender& contender : contenders) {
      std::vector<RTCRayHit> traced = rays;
      contender.seconds.push_back(secondsOf([&] { contender.trace(traced); }));
    }
  const double first = median(contenders[0].seconds);
  std::printf("| %-22s |", what);
  for (const Contender& contender : contenders)
    std::printf(" %6.2f |", double(rays.size()) / median(contender.seconds) * 1e-6);
  for (size_t i = 1; i < contenders.size(); i++)
    std::printf(" %5.2f |", isOfFirst ? first / median(contenders[i].seconds) : median(contenders[i].seconds) / first);
  std::printf("\n");
}

/* The original cube, and the cube loaded from a file. */
void measureFile(RTCDevice device, CbvhContext context, float rate, size_t count, unsigned turns) {
  const std::string path = std::string(std::getenv("TMPDIR") ? std::getenv("TMPDIR") : "/tmp") + "/capi_speed_" +
                           std::to_string(getpid()) + ".cbvh";
  const Cube cube;
  const CbvhCage cage = cube.cage(rate, 1);
  CbvhSurface made = nullptr, opened = nullptr;
  OK(cbvhNewSurface(context, &made));
  OK(cbvhSetSurfaceCage(made, &cage));
  OK(cbvhCommitSurface(made, nullptr, nullptr));
  OK(cbvhSaveSurface(made, path.c_str()));
  const double seconds = secondsOf([&] { OK(cbvhLoadSurface(context, path.c_str(), &opened)); });
  std::remove(path.c_str());
  {
    const Group inMemory(context, made), fromFile(context, opened);
    const Scene madeScene(device, inMemory), openedScene(device, fromFile);
    const auto single = [](RTCScene in) {
      return [in](std::vector<RTCRayHit>& rays) {
        for (RTCRayHit& r : rays) intersect(in, r);
      };
    };
    std::printf(
        "\n| opened in %.1f ms, million per second | original | from a file | file/original |\n|:--|--:|--:|--:|\n",
        1e3 * seconds);
    std::mt19937 random(3);
    for (bool areCoherent : {true, false})
      measure(areCoherent ? "coherent, closest" : "incoherent, closest", randomRays(random, count, areCoherent),
              {{"", single(madeScene), {}}, {"", single(openedScene), {}}}, turns, true);
  }
  cbvhReleaseSurface(made);
  cbvhReleaseSurface(opened);
}

} // namespace

int main(int argc, char** argv) {
  size_t count = 200000;
  float rate = 256;
  unsigned turns = 7;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string option = argv[i];
    if (option == "--rays") count = std::strtoul(argv[i + 1], nullptr, 10);
    else if (option == "--rate") rate = std::strtof(argv[i + 1], nullptr);
    else if (option == "--turns") turns = unsigned(std::strtoul(argv[i + 1], nullptr, 10));
    else {
      std::fprintf(stderr, "capi_speed: unknown option %s\n", argv[i]);
      return 1;
    }
  }
  RTCDevice device = rtcNewDevice(nullptr);
  ssize_t live = 0;
  rtcSetDeviceMemoryMonitorFunction(
      device,
      [](void* sum, ssize_t bytes, bool) {
        __atomic_add_fetch((ssize_t*)sum, bytes, __ATOMIC_RELAXED);
        return true;
      },
      &live);
  CbvhContext context = nullptr;
  OK(cbvhNewContext(nullptr, nullptr, nullptr, &context));
  {
    std::unique_ptr<Group> group;
    const double ours = secondsOf([&] { group = std::make_unique<Group>(context, rate); });
    const Scene scene(device, *group);
    Scene own(device, nullptr);
    const ssize_t before = live;
    RTCGeometry geometry = Cube().newInHost(device, rate);
    rtcAttachGeometry(own, geometry);
    rtcReleaseGeometry(geometry);
    const double theirs = secondsOf([&] { rtcCommitScene(own); });
    CbvhGroupStatistics statistics;
    OK(cbvhGetGroupStatistics(*group, &statistics));
    const double quads = double(statistics.numQuads);
    std::printf(
        "Embree %s; a displaced cube of %.2f million quads: %.1f bytes per quad, built in %.2f s; its own subdivision "
        "surface %.1f bytes, %.2f s\n\n",
        RTC_VERSION_STRING, quads * 1e-6, double(statistics.bytes) / quads, ours, double(live - before) / quads,
        theirs);
    std::printf(
        "| rays, million per second | user geometry | libembree_cbvh alone | Embree's own | user geometry/alone | user "
        "geometry/Embree's own |\n|:--|--:|--:|--:|--:|--:|\n");
    const auto single = [](RTCScene in) {
      return [in](std::vector<RTCRayHit>& rays) {
        for (RTCRayHit& r : rays) intersect(in, r);
      };
    };
    const auto any = [](RTCScene in) {
      return [in](std::vector<RTCRayHit>& rays) {
        for (RTCRayHit& r : rays) occluded(in, r.ray);
      };
    };
    const CbvhGroup handle = *group;
    const auto alone = [handle](std::vector<RTCRayHit>& rays) {
      for (RTCRayHit& r : rays) cbvhIntersect1(handle, (CbvhRayHit*)&r, nullptr);
    };
    const auto aloneAny = [handle](std::vector<RTCRayHit>& rays) {
      for (RTCRayHit& r : rays) cbvhOccluded1(handle, (CbvhRay*)&r.ray, nullptr);
    };
    std::mt19937 random(1);
    for (bool areCoherent : {true, false}) {
      const std::vector<RTCRayHit> rays = randomRays(random, count, areCoherent);
      const std::string set = areCoherent ? "coherent" : "incoherent";
      measure((set + ", closest").c_str(), rays, {{"", single(scene), {}}, {"", alone, {}}, {"", single(own), {}}},
              turns);
      measure((set + ", any").c_str(), rays, {{"", any(scene), {}}, {"", aloneAny, {}}, {"", any(own), {}}}, turns);
      measure((set + ", packets of 8").c_str(), rays,
              {{"", [&](std::vector<RTCRayHit>& r) { inPackets<8>(scene, r); }, {}},
               {"", alone, {}},
               {"", [&](std::vector<RTCRayHit>& r) { inPackets<8>(own, r); }, {}}},
              turns);
      measure((set + ", packets of 16").c_str(), rays,
              {{"", [&](std::vector<RTCRayHit>& r) { inPackets<16>(scene, r); }, {}},
               {"", alone, {}},
               {"", [&](std::vector<RTCRayHit>& r) { inPackets<16>(own, r); }, {}}},
              turns);
    }
  }
  {
    /* surfaces that overlap */
    constexpr unsigned count9 = 9;
    const Group together(context, rate / 2, count9);
    const Scene asOne(device, together);
    std::vector<std::unique_ptr<Group>> each;
    Scene asMany(device, nullptr);
    for (unsigned i = 0; i < count9; i++) {
      each.push_back(std::make_unique<Group>(context, rate / 2, 1, 1, int(i)));
      RTCGeometry geometry = cbvhNewGeometry(device, *each.back(), 0);
      rtcAttachGeometry(asMany, geometry);
      rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(asMany);
    const auto single = [](RTCScene in) {
      return [in](std::vector<RTCRayHit>& rays) {
        for (RTCRayHit& r : rays) intersect(in, r);
      };
    };
    const CbvhGroup handle = together;
    const auto alone = [handle](std::vector<RTCRayHit>& rays) {
      for (RTCRayHit& r : rays) cbvhIntersect1(handle, (CbvhRayHit*)&r, nullptr);
    };
    std::printf(
        "\n| nine surfaces, million per second | libembree_cbvh alone | as one geometry | as nine | one/alone | "
        "nine/alone |\n|:--|--:|--:|--:|--:|--:|\n");
    std::mt19937 random(2);
    for (bool areCoherent : {true, false})
      measure(areCoherent ? "coherent, closest" : "incoherent, closest", randomRays(random, count, areCoherent, 0.6f),
              {{"", alone, {}}, {"", single(asOne), {}}, {"", single(asMany), {}}}, turns, true);
  }
  measureFile(device, context, rate, count, turns);
  rtcReleaseDevice(device);
  cbvhReleaseContext(context);
  return failures ? 1 : 0;
}
