// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Hard cases: rays that are not finite, alone and among others, as single rays, packets and streams; directions of all
 * lengths, which scale only t. */

#include "hard_cases/hard_case.h"
#include "support/odd_rays.h"
#include "tracing/denormals.h"

#include <algorithm>
#include <functional>
#include <sstream>

namespace programs::test { namespace {

// --- entrances -----------------------------------------------------------------------------------

enum Entrance { Single, Packets4, Packets8, Packets16, Stream };

struct Call {
  Entrance entrance;
  bool coherent, any;
};

std::ostream& operator<<(std::ostream& out, const Call& call) {
  static const char* const names[] = {"single rays", "packets of 4", "packets of 8", "packets of 16", "a stream"};
  return out << names[call.entrance] << (call.coherent ? ", coherent" : "") << (call.any ? ", any hit" : "");
}

std::vector<Call> allCalls() {
  std::vector<Call> calls;
  for (Entrance entrance : {Single, Packets4, Packets8, Packets16, Stream})
    for (bool coherent : {false, true})
      for (bool any : {false, true}) calls.push_back({entrance, coherent, any});
  return calls;
}

// All lanes are active.
template<typename Packet, typename Trace>
void inPackets(std::vector<RTCRayHit>& rays, const Trace& trace) {
  constexpr size_t words = sizeof(RTCRayHit) / 4, N = sizeof(Packet) / sizeof(RTCRayHit);
  alignas(64) int valid[N];
  std::fill_n(valid, N, -1);
  for (size_t first = 0; first + N <= rays.size(); first += N) {
    alignas(64) Packet packet;
    char* lanes = (char*)&packet;
    for (size_t i = 0; i < words * N; i++)
      std::memcpy(lanes + 4 * i, (const char*)&rays[first + i % N] + 4 * (i / N), 4);
    trace(valid, packet);
    for (size_t i = 0; i < words * N; i++) std::memcpy((char*)&rays[first + i % N] + 4 * (i / N), lanes + 4 * i, 4);
  }
}

void trace(RTCScene scene, const Call& call, std::vector<RTCRayHit>& rays) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = call.coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  const bool any = call.any;
  const unsigned n = unsigned(rays.size());
  switch (call.entrance) {
  case Single:
    for (RTCRayHit& ray : rays) any ? rtcOccluded1(scene, &context, &ray.ray) : rtcIntersect1(scene, &context, &ray);
    break;
  case Packets4:
    inPackets<RTCRayHit4>(rays, [&](const int* valid, RTCRayHit4& p) {
      any ? rtcOccluded4(valid, scene, &context, &p.ray) : rtcIntersect4(valid, scene, &context, &p);
    });
    break;
  case Packets8:
    inPackets<RTCRayHit8>(rays, [&](const int* valid, RTCRayHit8& p) {
      any ? rtcOccluded8(valid, scene, &context, &p.ray) : rtcIntersect8(valid, scene, &context, &p);
    });
    break;
  case Packets16:
    inPackets<RTCRayHit16>(rays, [&](const int* valid, RTCRayHit16& p) {
      any ? rtcOccluded16(valid, scene, &context, &p.ray) : rtcIntersect16(valid, scene, &context, &p);
    });
    break;
  case Stream:
    any ? rtcOccluded1M(scene, &context, &rays[0].ray, n, sizeof(RTCRayHit))
        : rtcIntersect1M(scene, &context, rays.data(), n, sizeof(RTCRayHit));
    break;
  }
}

bool areSame(const RTCRayHit& a, const RTCRayHit& b) { return std::memcmp(&a, &b, sizeof(RTCRayHit)) == 0; }

std::string describe(const RTCRay& ray) {
  std::ostringstream out;
  out << "origin " << ray.org_x << " " << ray.org_y << " " << ray.org_z << ", direction " << ray.dir_x << " "
      << ray.dir_y << " " << ray.dir_z << ", from " << ray.tnear << " to " << ray.tfar;
  return out.str();
}

// --- rays that are not finite --------------------------------------------------------------------

class HardOddRays : public HardCase {
protected:
  Displacement displacement;

  SurfaceSettings settings() {
    SurfaceSettings s;
    s.displacement = &displacement;
    s.compression = compression();
    s.frameLevel = 2;
    s.rate = 32;
    return s;
  }
};
INSTANTIATE_TEST_SUITE_P(HardCases, HardOddRays, testing::ValuesIn(tracers()), tracerName);

// Rays of a picture of a cube around the origin, from outside and from inside.
std::vector<RTCRayHit> pictureOfCube(float scale) {
  std::vector<RTCRayHit> rays;
  for (unsigned i = 0; i < 64 * 64; i++) {
    const float x = 0.8f * float(i % 64) / 64 - 0.4f, y = 0.8f * float(i / 64) / 64 - 0.4f;
    rays.push_back(i % 1024 < 768 ? makeRay({scale * 0.1f, scale * 0.2f, scale * 4}, {x, y, -4})
                                  : makeRay({scale * 0.1f, scale * 0.2f, scale * 0.1f}, {x, y, 1}));
  }
  return rays;
}

// makeOdd: turns a ray into one that must miss.
void expectOddRaysMiss(RTCScene scene, const std::vector<RTCRayHit>& rays, Random& random,
                       const std::function<void(RTCRay&)>& makeOdd) {
  std::vector<RTCRayHit> mixed = rays;
  std::vector<bool> isOdd(rays.size());
  const double shares[] = {0, 0.1, 0.5, 1};
  double share = 0;
  for (size_t i = 0; i < rays.size(); i++) {
    if (i % 16 == 0) share = shares[random.below(4)];
    isOdd[i] = random.chance(share);
    if (isOdd[i]) makeOdd(mixed[i].ray);
  }
  for (const Call& call : allCalls()) {
    SCOPED_TRACE(testing::Message() << call);
    std::vector<RTCRayHit> alone = rays, found = mixed;
    trace(scene, {Single, false, call.any}, alone);
    trace(scene, call, found);
    size_t hits = 0;
    for (size_t i = 0; i < rays.size(); i++) {
      ASSERT_TRUE(areSame(found[i], isOdd[i] ? mixed[i] : alone[i]))
          << (isOdd[i] ? "odd ray " : "ray ") << i << ": " << describe(mixed[i].ray) << ", ends at "
          << found[i].ray.tfar;
      hits += !isOdd[i] && !areSame(found[i], rays[i]);
    }
    EXPECT_GT(hits, rays.size() / 4);
  }
}

TEST_P(HardOddRays, NonFiniteRaysMiss) {
  property(
      "rays with NaN or infinity in origin or direction, or a tnear or tfar of NaN, miss and remain unchanged; other "
      "rays of a packet or a stream have the same hits as alone");
  const SurfaceScene scene(device, cubeCage(), settings());
  Random random(34);
  expectOddRaysMiss(scene, pictureOfCube(1), random, [&](RTCRay& ray) { spoil(ray, random); });
}

// --- lengths -------------------------------------------------------------------------------------

TEST_P(HardOddRays, DirectionsOfAnyLengthDoNotLeak) {
  property(
      "rays from inside a closed surface, along an axis or nearly so, hit it whatever the length of their direction, "
      "1e-20 to 1e18, and at the same place");
  AllVertices recorder;
  Scene scene(device);
  recorder.build(device, scene, cubeCage(), settings());
  Random random(35);
  const std::vector<RTCRayHit> rays = raysNextToVertices(random, recorder.taken(), 16384);
  std::vector<RTCRayHit> ofUnitLength = rays;
  trace(scene, {Single, false, false}, ofUnitLength);
  for (bool flush : {false, true})
    for (int exponent : oddExponents) {
      const DenormalMode denormals(flush);
      const float length = std::ldexp(1.0f, exponent);
      const std::vector<RTCRayHit> scaled = withDirections(rays, length);
      for (const Call& call : {Call{Single, false, false}, Call{Single, false, true}, Call{Stream, true, false},
                               Call{Stream, true, true}}) {
        SCOPED_TRACE(testing::Message() << "length 2^" << exponent << ", " << call
                                        << (flush ? ", denormals are 0" : ""));
        std::vector<RTCRayHit> found = scaled;
        trace(scene, call, found);
        size_t leaks = 0, others = 0;
        for (size_t i = 0; i < rays.size(); i++) {
          const bool isFound = call.any ? found[i].ray.tfar < 0 : isHit(found[i]), expected = isHit(ofUnitLength[i]);
          // cGRID has GRID's triangles, where some rays pass through edges
          leaks += !isFound && compression() != RTC_COMPRESSION_CGRID;
          others +=
              isFound != expected || (isFound && !call.any && found[i].ray.tfar * length != ofUnitLength[i].ray.tfar);
        }
        EXPECT_EQ(leaks, 0u);
        EXPECT_EQ(others, 0u);
      }
    }
}

TEST_P(HardOddRays, DirectionsWithoutReciprocalMiss) {
  property("rays whose direction has no component above 2^-129, so that its reciprocal is infinite, miss and remain "
           "unchanged; other rays of a packet or a stream have the same hits as alone");
  const float scale = 0x1p-20f; // distances of hits would be finite
  Cage cage = cubeCage();
  for (Vec& p : cage.positions)
    for (float& x : p) x *= scale;
  SurfaceSettings s = settings();
  s.displacement = nullptr;
  const SurfaceScene scene(device, cage, s);
  for (bool flush : {false, true}) {
    Random random(36);
    const auto shorten = [](RTCRay& ray) {
      for (float* d : {&ray.dir_x, &ray.dir_y, &ray.dir_z}) *d = std::ldexp(*d, -131);
    };
    const DenormalMode denormals(flush);
    expectOddRaysMiss(scene, pictureOfCube(scale), random, shorten);
  }
}

}} // namespace programs::test
