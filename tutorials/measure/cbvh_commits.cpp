// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Measures commits of scenes with many geometries: all geometries, an edit, a mask, and a second scene; memory; and
 * rays. */

#include "basics/seconds.h"
#include "basics/vec.h"
#include "building/embree_device.h"
#include "measure/quantiles.h"
#include "programs/command_line.h"
#include "programs/run_program.h"

#include <CLI/CLI.hpp>
#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace programs { namespace {

struct Options {
  std::vector<size_t> counts{1, 10, 100, 10000, 100000};
  std::vector<std::string> accels{"bvh4.grid.eager", "cbvh.vert"};
  std::string shape = "ball";
  bool releaseInput = false;
  size_t quads = size_t(1) << 22;
  unsigned repeat = 5;
  size_t rays = 200000;
};

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

void displace(const RTCDisplacementFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; i++) {
    const float x = args->P_x[i], y = args->P_y[i], z = args->P_z[i];
    const float h = 0.05f * std::sin(9.0f * x) * std::sin(9.0f * y) * std::sin(9.0f * z);
    args->P_x[i] += h * args->Ng_x[i];
    args->P_y[i] += h * args->Ng_y[i];
    args->P_z[i] += h * args->Ng_z[i];
  }
}

struct Shape {
  std::vector<Vec3f> vertices;
  std::vector<unsigned> indices;

  size_t numFaces() const { return indices.size() / 4; }

  explicit Shape(const std::string& name) {
    if (name == "sheet") {
      const unsigned n = 64; // faces per side
      for (unsigned y = 0; y <= n; y++)
        for (unsigned x = 0; x <= n; x++)
          vertices.push_back({2.0f * float(x) / n - 1.0f, 2.0f * float(y) / n - 1.0f, 0.0f});
      for (unsigned y = 0; y < n; y++)
        for (unsigned x = 0; x < n; x++)
          for (unsigned i : {0u, 1u, n + 2, n + 1}) indices.push_back(y * (n + 1) + x + i);
      return;
    }
    for (int v = 0; v < 8; v++) vertices.push_back({v & 1 ? 1.0f : -1.0f, v & 2 ? 1.0f : -1.0f, v & 4 ? 1.0f : -1.0f});
    indices = {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
    if (name == "face") indices.resize(4);
  }
};

/* Geometries in a cube. */
class Shapes {
public:
  Shapes(EmbreeDevice& device, const Options& options, size_t count, float rate)
    : device(device),
      side(size_t(std::ceil(std::cbrt(double(count))))) {
    const Shape shape(options.shape);
    for (size_t i = 0; i < count; i++) {
      RTCGeometry geometry = rtcNewGeometry(device.handle(), RTC_GEOMETRY_TYPE_SUBDIVISION);
      const auto newBuffer = [&](RTCBufferType type, RTCFormat format, size_t bytes, size_t count) {
        return rtcSetNewGeometryBuffer(geometry, type, 0, format, bytes, count);
      };
      const size_t numVertices = shape.vertices.size(), numFaces = shape.numFaces();
      Vec3f* p = (Vec3f*)newBuffer(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, sizeof(Vec3f), numVertices);
      for (const Vec3f& v : shape.vertices) *p++ = v + center(i);
      std::copy(shape.indices.begin(), shape.indices.end(),
                (unsigned*)newBuffer(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, 4, shape.indices.size()));
      std::fill_n((unsigned*)newBuffer(RTC_BUFFER_TYPE_FACE, RTC_FORMAT_UINT, 4, numFaces), numFaces, 4u);
      if (options.releaseInput) {
        RTCCompressionArguments args;
        rtcInitCompressionArguments(&args);
        args.flags = RTC_COMPRESSION_FLAG_RELEASE_INPUT;
        rtcSetGeometryCompression(geometry, &args);
      }
      rtcSetGeometryTessellationRate(geometry, rate);
      rtcSetGeometryDisplacementFunction(geometry, displace);
      rtcCommitGeometry(geometry);
      geometries.push_back(geometry);
    }
  }

  ~Shapes() {
    for (RTCGeometry geometry : geometries) rtcReleaseGeometry(geometry);
  }
  Shapes(const Shapes&) = delete;
  Shapes& operator=(const Shapes&) = delete;

  RTCScene newScene() const {
    RTCScene scene = rtcNewScene(device.handle());
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_DYNAMIC);
    for (RTCGeometry geometry : geometries) rtcAttachGeometry(scene, geometry);
    return scene;
  }

  void move(size_t i) {
    float* p = (float*)rtcGetGeometryBufferData(geometries[i], RTC_BUFFER_TYPE_VERTEX, 0);
    for (int k = 0; k < 24; k++) p[k] += 0.01f;
    rtcUpdateGeometryBuffer(geometries[i], RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometries[i]);
  }

  void mask(size_t i, unsigned bits) {
    rtcSetGeometryMask(geometries[i], bits);
    rtcCommitGeometry(geometries[i]);
  }

  /* Rays from outside at random shapes. */
  std::vector<RTCRayHit> rays(size_t count) const {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(-1, 1);
    std::vector<RTCRayHit> rays(count);
    for (size_t i = 0; i < count; i++) {
      const auto randomVector = [&] { return Vec3f{uniform(random), uniform(random), uniform(random)}; };
      const Vec3f target = center(random() % geometries.size()) + randomVector();
      const float far = 4.0f * float(side);
      const Vec3f origin = Vec3f{far, far, far} + float(side) * randomVector();
      const Vec3f direction = target - origin;
      RTCRayHit& r = rays[i];
      std::memset(&r, 0, sizeof(r));
      r.ray.org_x = origin.x;
      r.ray.org_y = origin.y;
      r.ray.org_z = origin.z;
      r.ray.dir_x = direction.x;
      r.ray.dir_y = direction.y;
      r.ray.dir_z = direction.z;
      r.ray.tfar = INFINITY;
      r.ray.mask = ~0u;
      r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
    return rays;
  }

  size_t count() const { return geometries.size(); }

private:
  Vec3f center(size_t i) const { return 3.0f * Vec3f{float(i % side), float(i / side % side), float(i / side / side)}; }

  EmbreeDevice& device;
  size_t side;
  std::vector<RTCGeometry> geometries;
};

double traced(RTCScene scene, const std::vector<RTCRayHit>& rays, unsigned repeat) {
  std::vector<double> times;
  for (unsigned i = 0; i < repeat; i++) {
    std::vector<RTCRayHit> copy = rays;
    times.push_back(secondsOf([&] {
      for (RTCRayHit& ray : copy) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene, &context, &ray);
      }
    }));
  }
  return double(rays.size()) / median(times) * 1e-6;
}

void measure(const Options& options, const std::string& accel, size_t count) {
  const double numFaces = double(Shape(options.shape).numFaces() * count);
  const float rate = std::max(1.0f, std::round(float(std::sqrt(double(options.quads) / numFaces))));
  EmbreeDevice device("subdiv_accel=" + accel);
  const size_t none = device.memory().live();
  device.memory().resetPeak();
  const double begin = seconds();
  Shapes shapes(device, options, count, rate);
  const double made = seconds() - begin;
  const size_t input = device.memory().live() - none;
  RTCScene scene = shapes.newScene();
  const double all = secondsOf([&] { rtcCommitScene(scene); });
  device.check("committing");
  const size_t bytes = device.memory().live() - none, peak = device.memory().peak() - none;
  std::vector<double> edits, masks;
  for (unsigned i = 0; i < options.repeat; i++) {
    const size_t one = i * 7919 % shapes.count();
    if (!options.releaseInput)
      edits.push_back(secondsOf([&] {
        shapes.move(one);
        rtcCommitScene(scene);
      }));
    masks.push_back(secondsOf([&] {
      shapes.mask(one, 1u << i % 31);
      rtcCommitScene(scene);
    }));
  }
  const size_t before = device.memory().live();
  std::vector<RTCScene> others;
  double second = 0;
  size_t more[2] = {0, 0};
  for (int i = 0; i < 9; i++) {
    others.push_back(shapes.newScene());
    const double s = secondsOf([&] { rtcCommitScene(others.back()); });
    if (i == 0) {
      second = s;
      more[0] = device.memory().live() - before;
    }
  }
  more[1] = device.memory().live() - before;
  device.check("committing again");
  for (RTCScene other : others) rtcReleaseScene(other);
  const double speed = traced(scene, shapes.rays(options.rays), options.repeat);
  rtcReleaseScene(scene);
  const auto secondsAndShare = [&](const std::vector<double>& times) {
    if (times.empty()) return std::string("-");
    char text[64];
    std::snprintf(text, sizeof(text), "%.5f (%.2f%%)", median(times), 100 * median(times) / all);
    return std::string(text);
  };
  const double MiB = 1 << 20;
  std::printf("| %zu | %s | %.0f | %.4f | %.4f | %s | %s | %.5f | %.1f | %.1f | %.1f | %.1f | %.1f | %.3f |\n", count,
              accel.c_str(), double(rate), made, all, secondsAndShare(edits).c_str(), secondsAndShare(masks).c_str(),
              second, double(input) / MiB, double(bytes) / MiB, double(peak) / MiB, double(more[0]) / MiB,
              double(more[1]) / MiB, speed);
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Measures commits of scenes with many geometries: seconds, and MiB that the device holds.",
               "cbvh_commits");
  app.add_option("--geometries", options.counts, "comma-separated list of numbers of geometries")
      ->type_name("LIST")
      ->delimiter(',')
      ->check(countRange(1))
      ->capture_default_str();
  app.add_option("--accel", options.accels, "comma-separated list of values of subdiv_accel")
      ->type_name("LIST")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--shape", options.shape, "shape of a geometry: ball (6 faces), face, or sheet (64 x 64 faces)")
      ->type_name("SHAPE")
      ->check(CLI::IsMember({"ball", "face", "sheet"}))
      ->capture_default_str();
  app.add_option("--quads", options.quads, "approximate number of quads of all geometries together")
      ->type_name("N")
      ->check(countRange(1))
      ->capture_default_str();
  app.add_flag("--release-input", options.releaseInput,
               "release input buffers when a geometry is committed (compressed geometries only)");
  app.add_option("--repeat", options.repeat, "number of edits, masks and runs of rays, whose medians are reported")
      ->type_name("N")
      ->check(countRange(1))
      ->capture_default_str();
  app.add_option("--rays", options.rays, "number of rays at random geometries")
      ->type_name("N")
      ->check(countRange())
      ->capture_default_str();
  if (!parseCommandLine(app, argc, argv)) return 0;
  std::printf("| geometries | subdiv_accel | rate | geometries made, s | scene, s | one moved (of the scene) "
              "| one masked (of the scene) | a second scene, s | MiB of geometries | and scene | peak | second scene "
              "| nine more | Mrays/s |\n"
              "|--:|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (size_t count : options.counts)
    for (const std::string& accel : options.accels) measure(options, accel, count);
  return 0;
}

}} // namespace programs

int main(int argc, char** argv) {
  return programs::runProgram("cbvh_commits", [=] { return programs::run(argc, argv); });
}
