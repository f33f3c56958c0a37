// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares pictures of cbvh_pathtracer's shader with the CPU's. Both use the same random numbers: pixels are equal
 * except for rounding, until a ray takes a different path at an edge or a grazing angle. About one ray in 5,000 does,
 * and almost none in cVERT. */

#include "path_tracer.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "building/built_scene.h"
#include "building/embree_device.h"
#include "programs/view_options.h"
#include "scenes/catalogue.h"

#include <embree3/rtcore_vulkan.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <optional>

namespace programs { namespace {

constexpr unsigned samples = 3, bounces = 3;
constexpr ImageSize size = {64, 64};

Model cube() {
  SceneSettings settings;
  settings.scene = "cube";
  std::string warning;
  return loadScene(settings, warning);
}

/* Empty if there is no device. */
std::optional<RTCVulkanDeviceInfo> vulkanDeviceInfo() {
  const EmbreeDevice device("");
  const RTCVulkanDevice vulkan = rtcNewVulkanDevice(device.handle(), "");
  if (!vulkan) return std::nullopt;
  RTCVulkanDeviceInfo info;
  rtcGetVulkanDeviceInfo(vulkan, &info);
  rtcReleaseVulkanDevice(vulkan);
  return info;
}

bool hasVulkanDevice() { return vulkanDeviceInfo().has_value(); }
bool hasRayQuery() { return hasVulkanDevice() && vulkanDeviceInfo()->hasRayQuery; }

std::vector<Vec3f> render(PathTracer& tracer) {
  while (tracer.samples() < samples) tracer.addSample();
  return tracer.picture();
}

double meanOf(const std::vector<Vec3f>& pixels) {
  double sum = 0;
  for (const Vec3f& p : pixels) sum += double(p.x) + p.y + p.z;
  return sum / (3.0 * double(pixels.size()));
}

/* Largest difference of a channel, relative to the larger value. */
float relativeDifference(Vec3f a, Vec3f b) {
  const auto channel = [](float x, float y) { return x == y ? 0.0f : std::abs(x - y) / std::max(x, y); };
  return std::max({channel(a.x, b.x), channel(a.y, b.y), channel(a.z, b.z)});
}

TEST(PathTracerView, MatchesCamera) {
  const Vec3f up = {0, 1, 0};
  const Camera camera({1, 2, 3}, {0, 0.5f, -1}, up, 40.0f, {30, 20});
  const PathView view = makePathView(camera, up, bounces, Shutter());
  for (float y : {0.0f, 7.0f, 19.0f})
    for (float x : {0.0f, 11.0f, 29.0f}) {
      const Vec3f direction = path::unitVector(view.corner + (x + 0.5f) * view.right + (y + 0.5f) * view.down);
      EXPECT_LT(length(direction - camera.direction(x, y)), 1e-6f);
    }
}

/* A triangle's normal is the product of two edges. */
TEST(PathTracerNormal, HasUnitLengthAtEveryScale) {
  const Vec3f normal{0.3f, -1.7f, 0.6f}, direction{0, 0, 1};
  const Vec3f expected = path::facingNormal(normal, direction);
  EXPECT_LT(dot(expected, direction), 0.0f);
  for (int exponent = -120; exponent <= 126; exponent++)
    EXPECT_LT(length(path::facingNormal(normal * std::ldexp(1.0f, exponent), direction) - expected), 3e-7f) << exponent;
  for (const Vec3f none : {Vec3f{}, Vec3f{NAN, 1, 0}, Vec3f{INFINITY, 1, 0}})
    EXPECT_EQ(length(path::facingNormal(none, direction) + direction), 0.0f);
}

/* The cube in other units, without its displacement. */
std::vector<Vec3f> pictureAtScale(float scale, const char* representation, bool isOnVulkan) {
  SceneSettings settings;
  settings.scene = "cube";
  std::string warning;
  Model model = loadScene(settings, warning);
  model.displacement = nullptr;
  for (Vec3f& p : model.cage.positions) p = p * scale;
  BuildSettings build;
  build.level = 4;
  const BuiltScene grid(model, {RepresentationKind::Grid}, build);
  const BuiltScene scene(model, parseRepresentations(representation, 2)[0], build);
  const unsigned threads = threadCount(0);
  const PathView view =
      makePathView(chooseCamera("full", model, grid, size, threads), model.view.up, bounces, Shutter());
  return render(isOnVulkan ? *makeVulkanPathTracer(scene.handle(), view, "")
                           : *makeCpuPathTracer(scene.handle(), view, threads));
}

size_t numDifferingAtScale(int exponent, const std::vector<Vec3f>& expected, const char* representation,
                           bool isOnVulkan) {
  const std::vector<Vec3f> pixels = pictureAtScale(std::ldexp(1.0f, exponent), representation, isOnVulkan);
  size_t count = 0;
  for (size_t i = 0; i < expected.size(); i++) count += !(relativeDifference(expected[i], pixels[i]) <= 1e-2f);
  return count;
}

/* Powers of two, from 1e-12 to 1e14 units. Hits of Embree's GRID are not finite at 1e14 units. */
TEST(PathTracerNormal, UnitsDoNotChangeThePicture) {
  const std::vector<Vec3f> grid = pictureAtScale(1, "grid", false), cvert = pictureAtScale(1, "cvert", false);
  for (const int exponent : {-27, 38})
    EXPECT_LE(numDifferingAtScale(exponent, grid, "grid", false), grid.size() / 50) << exponent;
  for (const int exponent : {-40, -27, 38, 46})
    EXPECT_LE(numDifferingAtScale(exponent, cvert, "cvert", false), cvert.size() / 50) << exponent;
}

TEST(PathTracerNormal, UnitsDoNotChangeThePictureOfTheShader) {
  if (!hasVulkanDevice()) GTEST_SKIP() << "no Vulkan device";
  const std::vector<Vec3f> expected = pictureAtScale(1, "cvert", true);
  for (const int exponent : {-40, 46})
    EXPECT_LE(numDifferingAtScale(exponent, expected, "cvert", true), expected.size() / 50) << exponent;
}

class PathTracerPictures : public testing::TestWithParam<const char*> {};

TEST_P(PathTracerPictures, MatchOnBothDevices) {
  if (!hasVulkanDevice()) GTEST_SKIP() << "no Vulkan device";
  const Model model = cube();
  BuildSettings build;
  build.level = 4;
  const BuiltScene grid(model, {RepresentationKind::Grid}, build);
  const BuiltScene scene(model, parseRepresentations(GetParam(), 2)[0], build);
  const unsigned threads = threadCount(0);
  const PathView view =
      makePathView(chooseCamera("close", model, grid, size, threads), model.view.up, bounces, Shutter());
  const std::vector<Vec3f> expected = render(*makeCpuPathTracer(scene.handle(), view, threads));
  const std::vector<Vec3f> pixels = render(*makeVulkanPathTracer(scene.handle(), view, ""));

  if (hasRayQuery()) {
    const std::vector<Vec3f> byQuery = render(*makeVulkanPathTracer(scene.handle(), view, "", true));
    ASSERT_EQ(byQuery.size(), pixels.size());
    size_t others = 0;
    for (size_t i = 0; i < pixels.size(); i++) others += !(relativeDifference(byQuery[i], pixels[i]) <= 1e-3f);
    std::printf("%s: %zu of %zu pixels differ by ray queries\n", GetParam(), others, pixels.size());
    EXPECT_LE(others, pixels.size() / 1000);
  }

  ASSERT_EQ(expected.size(), pixels.size());
  size_t differing = 0;
  float most = 0;
  for (size_t i = 0; i < pixels.size(); i++) {
    const float difference = relativeDifference(expected[i], pixels[i]);
    most = std::max(most, difference);
    differing += !(difference <= 1e-3f);
  }
  const double means[2] = {meanOf(expected), meanOf(pixels)};
  std::printf("%s: %zu of %zu pixels differ by more than 1/1000, the most by %g; means %.7f and %.7f\n", GetParam(),
              differing, pixels.size(), double(most), means[0], means[1]);
  EXPECT_LE(differing, pixels.size() / 100);
  EXPECT_NEAR(means[0], means[1], 1e-3 * means[0]);
  EXPECT_GT(means[0], 0.05); // the picture is not black
}

/* A picture of a cube that rotates while the shutter is open. */
std::vector<Vec3f> pictureOfMotion(const char* representation, const Shutter& shutter) {
  SceneSettings settings;
  settings.scene = "cube";
  settings.motion = "turn";
  std::string warning;
  const Model model = loadScene(settings, warning);
  BuildSettings build;
  build.level = 4;
  const BuiltScene grid(model, {RepresentationKind::Grid}, build);
  const BuiltScene scene(model, parseRepresentations(representation, 2)[0], build);
  const unsigned threads = threadCount(0);
  const PathView view = makePathView(chooseCamera("full", model, grid, size, threads), model.view.up, bounces, shutter);
  return render(*makeCpuPathTracer(scene.handle(), view, threads));
}

size_t numDiffering(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
  size_t count = 0;
  for (size_t i = 0; i < a.size(); i++) count += relativeDifference(a[i], b[i]) > 0.05f;
  return count;
}

TEST(PathTracerMotion, IsBlurredWhileTheShutterIsOpen) {
  const std::vector<Vec3f> grid = pictureOfMotion("grid", {0, 1}), ours = pictureOfMotion("cvert", {0, 1});
  EXPECT_LE(numDiffering(grid, ours), grid.size() / 50);
  for (float time : {0.0f, 1.0f})
    EXPECT_GE(numDiffering(ours, pictureOfMotion("cvert", {time, time})), ours.size() / 10) << "at " << time;
}

INSTANTIATE_TEST_SUITE_P(Representations, PathTracerPictures, testing::Values("grid", "cleaf-only", "cvert"));

}} // namespace programs
