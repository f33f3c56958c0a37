// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "pictures/shading.h"
#include "measure/hit_metrics.h"

namespace programs {

HitShader::HitShader(Vec3f middle, Vec3f up, HitColors colors) : up(up), colors(colors) {
  const Vec3f side = normalize(cross(middle, up));
  key = normalize(-0.55f * middle + 0.75f * up + -0.65f * side);
  fill = normalize(-0.6f * middle + -0.1f * up + 0.8f * side);
}

Vec3f HitShader::color(const Ray& ray, const SurfaceHit& hit) const {
  const Vec3f clay{0.47f, 0.46f, 0.45f}, backside{0.9f, 0.1f, 0.75f};
  Vec3f n = normalize(hit.normal);
  const bool away = dot(n, ray.direction) > 0.0f;
  if (away) n = -n;
  const Vec3f half = normalize(key - ray.direction);
  const float diffuse = std::max(0.0f, dot(n, key));
  const float soft = std::max(0.0f, dot(n, fill));
  const float sky = 0.5f + 0.5f * dot(n, up);
  const float shine = std::pow(std::max(0.0f, dot(n, half)), 40.0f) * diffuse;
  const Vec3f light = 1.15f * diffuse * Vec3f{1.0f, 0.94f, 0.84f} + 0.25f * soft * Vec3f{0.6f, 0.75f, 1.0f} +
                      0.16f * sky * Vec3f{0.8f, 0.9f, 1.0f};
  return (away && colors == HitColors::Sides ? backside : clay) * light + 0.12f * shine * Vec3f{1, 1, 1};
}

Vec3f backgroundColor(float fraction) { return lerp({0.86f, 0.89f, 0.93f}, {0.62f, 0.66f, 0.72f}, fraction); }

Image grayImage(ImageSize size, const std::vector<float>& values) {
  Image image(size);
  for (size_t i = 0; i < values.size(); i++) image.set(i, {values[i], values[i], values[i]});
  return image;
}

Image compareAmbient(ImageSize size, const std::vector<float>& grid, const std::vector<float>& light) {
  constexpr float gain = 4.0f;
  Image image({3 * size.width, size.height});
  for (size_t i = 0; i < grid.size(); i++) {
    const size_t width = size_t(size.width), pixel = i / width * 3 * width + i % width;
    const float difference = std::clamp(0.5f + gain * (light[i] - grid[i]), 0.0f, 1.0f);
    const float values[3] = {grid[i], light[i], difference};
    for (size_t k = 0; k < 3; k++) image.set(pixel + k * width, {values[k], values[k], values[k]});
  }
  return image;
}

Vec3f errorColor(float error) {
  /* Colors at 0, 1.25, 2.5, 3.75 and 5 pixels. */
  const Vec3f stops[5] = {
      {0.02f, 0.05f, 0.75f}, {0.0f, 0.65f, 0.85f}, {0.1f, 0.75f, 0.1f}, {1.0f, 0.8f, 0.0f}, {1.0f, 0.2f, 0.6f}};
  if (error == falseHitError) return {0, 0, 0};
  if (error == missError) return {1.0f, 0.35f, 0.0f};
  if (!(error >= 0.0f)) return {1, 1, 1};
  const float x = std::min(error / 1.25f, 4.0f);
  const int k = std::min(int(x), 3);
  return lerp(stops[k], stops[k + 1], x - float(k));
}

Image errorHeatMap(ImageSize size, const std::vector<float>& errors) {
  Image image(size);
  for (size_t i = 0; i < errors.size(); i++) image.set(i, errorColor(errors[i]));
  return image;
}

} // namespace programs
