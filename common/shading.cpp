// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "shading.h"
#include "hit_metrics.h"

namespace cbvh {
namespace {

Vec3f background(float fraction)
{
  return lerp({0.86f, 0.89f, 0.93f}, {0.62f, 0.66f, 0.72f}, fraction);
}

} // namespace

Image shadeHits(ImageSize size, const std::vector<Ray>& rays, const std::vector<SurfaceHit>& hits, Vec3f up)
{
  const Vec3f skin{0.56f, 0.46f, 0.33f}, backside{0.9f, 0.1f, 0.75f};
  const Vec3f middle = rays[rays.size() / 2 + size_t(size.width) / 2].direction;
  const Vec3f side = normalize(cross(middle, up));
  const Vec3f key = normalize(-0.55f * middle + 0.75f * up + -0.65f * side); // towards the light
  const Vec3f fill = normalize(-0.6f * middle + -0.1f * up + 0.8f * side);
  Image image(size);
  for (size_t i = 0; i < hits.size(); i++)
  {
    if (!hits[i].hit())
    {
      image.set(i, background(float(i / size_t(size.width)) / float(size.height)));
      continue;
    }
    Vec3f n = normalize(hits[i].normal);
    const bool away = dot(n, rays[i].direction) > 0.0f;
    if (away)
      n = -n; // lit from its other side, but in another colour
    const Vec3f half = normalize(key - rays[i].direction);
    const float diffuse = std::max(0.0f, dot(n, key));
    const float soft = std::max(0.0f, dot(n, fill));
    const float sky = 0.5f + 0.5f * dot(n, up);
    const float shine = std::pow(std::max(0.0f, dot(n, half)), 40.0f) * diffuse;
    const Vec3f light = 1.15f * diffuse * Vec3f{1.0f, 0.94f, 0.84f} + 0.25f * soft * Vec3f{0.6f, 0.75f, 1.0f} +
                        0.16f * sky * Vec3f{0.8f, 0.9f, 1.0f};
    image.set(i, (away ? backside : skin) * light + 0.12f * shine * Vec3f{1, 1, 1});
  }
  return image;
}

Image errorHeatMap(ImageSize size, const std::vector<float>& errors)
{
  /* Stops at 0, 1.25, 2.5, 3.75 and 5 pixels. */
  const Vec3f stops[5] = {{0.02f, 0.05f, 0.75f}, {0.0f, 0.65f, 0.85f}, {0.1f, 0.75f, 0.1f},
                          {1.0f, 0.8f, 0.0f}, {1.0f, 0.2f, 0.6f}};
  Image image(size);
  for (size_t i = 0; i < errors.size(); i++)
  {
    Vec3f color{1, 1, 1};
    if (errors[i] == falseHitError)
      color = {0, 0, 0};
    else if (errors[i] == missError)
      color = {1.0f, 0.35f, 0.0f};
    else if (errors[i] >= 0.0f)
    {
      const float x = std::min(errors[i] / 1.25f, 4.0f);
      const int k = std::min(int(x), 3);
      color = lerp(stops[k], stops[k + 1], x - float(k));
    }
    image.set(i, color);
  }
  return image;
}

} // namespace cbvh
