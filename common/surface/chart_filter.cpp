// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/chart_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace programs {
namespace {

constexpr int maxChannels = 3;
constexpr int maxTaps = 48;        // along an axis; larger footprints skip texels
constexpr float tolerance = 0.01f; // texels, above the rounding error of coordinates in maps of 64k x 64k
constexpr float largestCoordinate = float(1 << 24); // texels; beyond, floats do not distinguish texels

using Values = std::array<double, maxChannels>;

float cross(Vec2f a, Vec2f b) { return a.x * b.y - a.y * b.x; }

float dot(Vec2f a, Vec2f b) { return a.x * b.x + a.y * b.y; }

/* Widths and distances in texels of the full image.
 *
 * The texture blends two mip levels whose texels are as wide as the filter up to twice as wide, and reads one texel
 * around the point bilinearly. So it reaches up to 1.5 * 2 widths. If the filter is narrower than a texel, it is
 * bilinear. */
struct Footprint {
  explicit Footprint(float width)
    : isMagnified(width <= 1.0f),
      radius(isMagnified ? 1.0f : std::sqrt(1.5f * width * width - 0.5f)),
      textureRadius(isMagnified ? 1.0f : 3.0f * width),
      blendEnd(isMagnified ? 1.0f : 4.0f * width),
      fitRadius(std::max(2.5f, 2.0f * radius)) // two rows of texels or more, to find a slope
  {}

  float largestRadius() const { return std::max(blendEnd, fitRadius); }

  bool isMagnified;
  float radius;        // of a tent with the same variance as the texture's filter; bilinear if magnified
  float textureRadius; // nearer to a chart's end, the texture reads other charts
  float blendEnd;      // farther, the texture alone is read
  float fitRadius;
};

/* The ends of a chart near a point, in texels relative to it. */
class NearEnds {
public:
  void add(Vec2f a, Vec2f b) {
    const Vec2f along = b - a;
    const float length2 = dot(along, along);
    const float t = length2 > 0.0f ? std::clamp(-dot(a, along) / length2, 0.0f, 1.0f) : 0.0f;
    const Vec2f nearest = a + along * t;
    distance2 = std::min(distance2, dot(nearest, nearest));
    /* An end that is seen from outside is behind another one. */
    const float length = std::sqrt(length2), side = cross(along, {-a.x, -a.y});
    if (length2 > 0.0f && side >= -tolerance * length)
      ends.push_back({a, along, std::max(side, 0.0f), length2, tolerance * length});
  }

  float distance() const { return std::sqrt(distance2); }

  /* True if the line from the point to q leaves the chart. */
  bool separates(Vec2f q) const {
    return std::any_of(ends.begin(), ends.end(), [&](const End& end) {
      const float side = cross(end.along, q - end.a);
      if (side >= 0.0f) return false;
      const float at = dot(q * (end.pointSide / (end.pointSide - side)) - end.a, end.along);
      return at >= -end.margin && at <= end.length2 + end.margin;
    });
  }

private:
  struct End {
    Vec2f a, along;
    float pointSide, length2, margin;
  };

  std::vector<End> ends;
  float distance2 = INFINITY;
};

/* Calls visit(offset, weight, values) for the texels within a radius of a point, with the weights of a tent. */
template<typename Visit>
void forTexels(const HeightTexture& texture, unsigned image, Vec2f center, float radius, const Visit& visit) {
  const int step = std::max(1, int(std::ceil(2.0f * radius / float(maxTaps))));
  const auto first = [&](float c) { return int(std::ceil(c - radius - 0.5f)); };
  const auto last = [&](float c) { return int(std::floor(c + radius - 0.5f)); };
  const int count = last(center.x) - first(center.x) + 1;
  std::vector<float> row(size_t(std::max(0, step == 1 ? count : 1)) * maxChannels);
  for (int y = first(center.y); y <= last(center.y); y += step) {
    if (step == 1 && count > 0) texture.texels(image, first(center.x), y, count, row.data());
    for (int i = 0; i < count; i += step) {
      const int x = first(center.x) + i;
      if (step > 1) texture.texels(image, x, y, 1, row.data());
      const Vec2f offset{float(x) + 0.5f - center.x, float(y) + 0.5f - center.y};
      const float weight = std::max(0.0f, radius - std::abs(offset.x)) * std::max(0.0f, radius - std::abs(offset.y));
      if (weight > 0.0f) visit(offset, weight, step == 1 ? &row[size_t(i * texture.numChannels())] : row.data());
    }
  }
}

/* The plane that fits texels best. */
class PlaneFit {
public:
  PlaneFit(int channels, float radius) : channels(channels), radius(radius) {}

  void add(Vec2f p, double w, const float* values) {
    weight += w;
    x += w * p.x;
    y += w * p.y;
    xx += w * p.x * p.x;
    xy += w * p.x * p.y;
    yy += w * p.y * p.y;
    for (int i = 0; i < channels; i++) {
      sum[i] += w * values[i];
      sumX[i] += w * p.x * values[i];
      sumY[i] += w * p.y * values[i];
      least[i] = std::min(least[i], double(values[i]));
      most[i] = std::max(most[i], double(values[i]));
    }
  }

  bool isEmpty() const { return !(weight > 0.0); }

  /* Exceeds the range of the texels by at most half of it. */
  Values at(double px, double py) const {
    constexpr double ridge = 1e-4; // no slope across a single row of texels
    const double mx = x / weight, my = y / weight, least2 = ridge * radius * radius;
    const double cxx = xx / weight - mx * mx + least2, cyy = yy / weight - my * my + least2;
    const double cxy = xy / weight - mx * my;
    const double determinant = cxx * cyy - cxy * cxy;
    Values values{};
    for (int i = 0; i < channels; i++) {
      const double mean = sum[i] / weight, cx = sumX[i] / weight - mx * mean, cy = sumY[i] / weight - my * mean;
      const double slopeX = (cx * cyy - cy * cxy) / determinant, slopeY = (cy * cxx - cx * cxy) / determinant;
      const double half = 0.5 * (most[i] - least[i]);
      values[i] = std::clamp(mean + slopeX * (px - mx) + slopeY * (py - my), least[i] - half, most[i] + half);
    }
    return values;
  }

private:
  int channels;
  double radius;
  double weight = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  Values sum{}, sumX{}, sumY{}, least{INFINITY, INFINITY, INFINITY}, most{-INFINITY, -INFINITY, -INFINITY};
};

/* Returns false if the chart has no texels near the point. */
bool filterInChart(const HeightTexture& texture, unsigned image, Vec2f center, const Footprint& footprint,
                   const NearEnds& ends, float* values) {
  const int channels = texture.numChannels();
  Values sum{};
  double weight = 0, outside = 0, outsideX = 0, outsideY = 0;
  forTexels(texture, image, center, footprint.radius, [&](Vec2f offset, double w, const float* texel) {
    weight += w;
    if (ends.separates(offset)) {
      outside += w;
      outsideX += w * offset.x;
      outsideY += w * offset.y;
    } else
      for (int i = 0; i < channels; i++) sum[i] += w * texel[i];
  });
  if (outside > 0.0) {
    PlaneFit fit(channels, footprint.fitRadius);
    forTexels(texture, image, center, footprint.fitRadius, [&](Vec2f offset, double w, const float* texel) {
      if (!ends.separates(offset)) fit.add(offset, w, texel);
    });
    if (fit.isEmpty()) return false;
    const Values continued = fit.at(outsideX / outside, outsideY / outside);
    for (int i = 0; i < channels; i++) sum[i] += outside * continued[i];
  }
  for (int i = 0; i < channels; i++) values[i] = float(sum[i] / weight);
  return true;
}

} // namespace

void ChartFilter::sample(unsigned image, unsigned chart, Vec2f at, Vec2f width, float* values) const {
  const Vec2f size = texture.size(image), center{at.x * size.x, at.y * size.y};
  const float shorter = std::min(size.x, size.y);
  const Footprint footprint(std::min(std::max(width.x, width.y) * shorter, shorter));
  const Vec2f reach{footprint.largestRadius() / size.x, footprint.largestRadius() / size.y};
  NearEnds ends;
  charts.forEndsNear(chart, at - reach, at + reach, [&](const TextureCharts::End& end) {
    const auto inTexels = [&](Vec2f p) { return Vec2f{(p.x - at.x) * size.x, (p.y - at.y) * size.y}; };
    ends.add(inTexels(end.a), inTexels(end.b));
  });
  const bool isNear = ends.distance() < footprint.blendEnd && std::abs(center.x) < largestCoordinate &&
                      std::abs(center.y) < largestCoordinate;
  float own[maxChannels];
  if (!isNear || !filterInChart(texture, image, center, footprint, ends, own)) {
    texture.sample(image, at.x, at.y, width.x, width.y, values);
    return;
  }
  std::copy_n(own, texture.numChannels(), values);
  if (ends.distance() <= footprint.textureRadius) return;
  texture.sample(image, at.x, at.y, width.x, width.y, values);
  const float t = (ends.distance() - footprint.textureRadius) / (footprint.blendEnd - footprint.textureRadius);
  for (int i = 0; i < texture.numChannels(); i++) values[i] = own[i] + t * (values[i] - own[i]);
}

} // namespace programs
