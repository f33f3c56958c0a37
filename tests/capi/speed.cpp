// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays per second of one thread on a displaced cube: through the user geometry of the surrounding Embree, by
 * libembree_cbvh's own functions, on Embree's subdivision surface, and from a file. Closest points per second, also of
 * Embree's triangles. Prints medians of interleaved runs.
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

/* The triangles of a surface as a mesh of Embree, and its closest points by a function of the program. */
class Triangles {
public:
  Triangles(RTCDevice device, CbvhSurface surface) : scene(rtcNewScene(device)) {
    const auto add = [](void* self, const CbvhPart* part) {
      Triangles& to = *(Triangles*)self;
      const unsigned first = unsigned(to.vertices.size());
      for (unsigned i = 0; i < part->width * part->height; i++)
        to.vertices.push_back({part->vertices[3 * i], part->vertices[3 * i + 1], part->vertices[3 * i + 2]});
      for (unsigned y = 0; y + 1 < part->height; y++)
        for (unsigned x = 0; x + 1 < part->width; x++) {
          const unsigned a = first + y * part->width + x, b = a + 1, c = a + part->width, d = c + 1;
          to.indices.insert(to.indices.end(), {a, b, c, c, b, d});
        }
      return 1;
    };
    OK(cbvhForEachPart(surface, 0, add, this));
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const size_t numVertices = vertices.size();
    vertices.push_back({0, 0, 0}); // padding
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices.data(), 0, 12,
                               numVertices);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices.data(), 0, 12,
                               indices.size() / 3);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
  }
  ~Triangles() { rtcReleaseScene(scene); }
  Triangles(const Triangles&) = delete;
  Triangles& operator=(const Triangles&) = delete;

  float distance(const Vec& p) const {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    RTCPointQuery query = {p[0], p[1], p[2], 0, INFINITY};
    rtcPointQuery(scene, &query, &context, decreaseRadius, (void*)this);
    return query.radius;
  }

private:
  static float dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  static Vec along(const Vec& a, float t, const Vec& b) { return {a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]}; }

  static bool decreaseRadius(RTCPointQueryFunctionArguments* args) {
    const Triangles& self = *(const Triangles*)args->userPtr;
    const unsigned* const corners = &self.indices[3 * args->primID];
    const Vec p = {args->query->x, args->query->y, args->query->z};
    const Vec offset = along(p, -1, self.closest(p, corners));
    const float distance = std::sqrt(dot(offset, offset));
    if (!(distance < args->query->radius)) return false;
    args->query->radius = distance;
    return true;
  }

  /* By the regions of Ericson, Real-Time Collision Detection, section 5.1.5. */
  Vec closest(const Vec& p, const unsigned* corners) const {
    const Vec &a = vertices[corners[0]], &b = vertices[corners[1]], &c = vertices[corners[2]];
    const Vec ab = along(b, -1, a), ac = along(c, -1, a), ap = along(p, -1, a), bp = along(p, -1, b),
              cp = along(p, -1, c);
    const float d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const float d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const float d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const float va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return along(a, d1 / (d1 - d3), ab);
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return along(a, d2 / (d2 - d6), ac);
    if (va <= 0 && d4 >= d3 && d5 >= d6) return along(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), along(c, -1, b));
    return along(along(a, vb / (va + vb + vc), ab), vc / (va + vb + vc), ac);
  }

  const RTCScene scene;
  std::vector<Vec> vertices;
  std::vector<unsigned> indices;
};

/* Closest points of a surface as cTILE and as cVERT, and of its triangles in Embree. */
void measurePoints(RTCDevice device, float rate, size_t count, unsigned turns) {
  CbvhContext contexts[2];
  OK(cbvhNewContext(nullptr, nullptr, nullptr, &contexts[0]));
  OK(cbvhNewContext("subdiv_accel=cbvh.vert", nullptr, nullptr, &contexts[1]));
  {
    const Group tiles(contexts[0], rate), blocks(contexts[1], rate);
    const Triangles triangles(device, cbvhGetGroupSurface(tiles, 0));
    std::mt19937 random(4);
    std::normal_distribution<float> normal;
    const std::vector<RTCRayHit> hits = randomRays(random, count, false);
    std::printf("\n| closest points, million per second | Embree's triangles | cTILE | cVERT | cTILE/Embree's | "
                "cVERT/Embree's |\n|:--|--:|--:|--:|--:|--:|\n");
    const auto ours = [](CbvhGroup group) {
      return [group](std::vector<RTCRayHit>& points) {
        for (RTCRayHit& r : points) {
          CbvhPointQuery query = CbvhPointQuery();
          query.x = r.ray.org_x;
          query.y = r.ray.org_y;
          query.z = r.ray.org_z;
          query.radius = INFINITY;
          CbvhClosestPoint closest;
          cbvhPointQuery(group, &query, &closest);
          r.ray.tfar = closest.distance;
        }
      };
    };
    const auto theirs = [&](std::vector<RTCRayHit>& points) {
      for (RTCRayHit& r : points) r.ray.tfar = triangles.distance({r.ray.org_x, r.ray.org_y, r.ray.org_z});
    };
    for (const float distance : {0.003f, 0.1f, 3.0f}) {
      std::vector<RTCRayHit> points;
      for (const RTCRayHit& ray : hits) {
        CbvhRayHit r;
        std::memcpy(&r, &ray, sizeof(r));
        if (!cbvhIntersect1(tiles, &r, nullptr)) continue;
        RTCRayHit point = ray;
        point.ray.org_x += r.ray.tfar * r.ray.dir_x + distance * normal(random);
        point.ray.org_y += r.ray.tfar * r.ray.dir_y + distance * normal(random);
        point.ray.org_z += r.ray.tfar * r.ray.dir_z + distance * normal(random);
        points.push_back(point);
      }
      std::vector<RTCRayHit> a = points, b = points;
      theirs(a);
      ours(tiles)(b);
      for (size_t i = 0; i < a.size(); i++) CHECK(std::fabs(a[i].ray.tfar - b[i].ray.tfar) <= 1e-5f * (1 + distance));
      char what[32];
      std::snprintf(what, sizeof(what), "%g from the surface", double(distance));
      measure(what, points, {{"", theirs, {}}, {"", ours(tiles), {}}, {"", ours(blocks), {}}}, turns, true);
    }
  }
  for (CbvhContext context : contexts) cbvhReleaseContext(context);
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
  measurePoints(device, rate, count, turns);
  rtcReleaseDevice(device);
  cbvhReleaseContext(context);
  return failures ? 1 : 0;
}
