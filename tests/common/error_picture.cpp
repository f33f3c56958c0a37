// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "pictures/error_picture.h"
#include "measure/hit_metrics.h"
#include "measure/quad_size.h"
#include "pictures/shading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace programs::test { namespace {

using Rgb = std::array<uint8_t, 3>;

Rgb colorOf(float error) {
  Image image({1, 1});
  image.set(0, errorColor(error));
  return {image.rgb[0], image.rgb[1], image.rgb[2]};
}

constexpr Rgb black{0, 0, 0};

/* Pixels of the scale, below the errors. */
class ScaleOf {
public:
  ScaleOf(ImageSize size, float quadPixels)
    : size(size),
      image(errorPicture(size, std::vector<float>(size_t(size.width) * size.height, 0.01f), quadPixels)) {}

  Rgb at(int x, int y) const {
    const uint8_t* const p = &image.rgb[3 * (size_t(y) * size_t(image.size.width) + size_t(x))];
    return {p[0], p[1], p[2]};
  }

  int count(Rgb color, int x0 = 0, int x1 = 1 << 20) const {
    int n = 0;
    for (int y = size.height; y < image.size.height; y++)
      for (int x = x0; x < std::min(x1, size.width); x++) n += at(x, y) == color;
    return n;
  }

  /* Extent of the colors of errors in the longest row, from the left. */
  std::pair<int, int> bar() const {
    std::pair<int, int> longest{0, -1};
    for (int y = size.height + 2; y < image.size.height; y++) {
      int first = 0;
      while (first < size.width && at(first, y) != colorOf(0.0f)) first++;
      int last = first;
      while (last < size.width && at(last, y) != colorOf(5.0f)) last++;
      if (last < size.width && last - first > longest.second - longest.first) longest = {first, last};
    }
    return longest;
  }

  ImageSize size;
  Image image;
};

TEST(ErrorPicture, ContainsTheErrorsAboveTheScale) {
  const ImageSize size{300, 20};
  std::vector<float> errors;
  for (int i = 0; i < size.width * size.height; i++) errors.push_back(float(i % 70) / 10 - 1.0f);
  const Image picture = errorPicture(size, errors, 1.0f), map = errorHeatMap(size, errors);
  EXPECT_EQ(picture.size.width, size.width);
  EXPECT_GT(picture.size.height, size.height);
  EXPECT_TRUE(std::equal(map.rgb.begin(), map.rgb.end(), picture.rgb.begin()));
}

TEST(ErrorPicture, ScaleHasTheColorsFromZeroToFivePixels) {
  for (int width : {200, 500, 1024, 3000}) {
    const ScaleOf scale({width, 10}, 0.0f);
    const auto [first, last] = scale.bar();
    EXPECT_GE(last - first, std::min(100, width / 5)) << width;
    EXPECT_GT(scale.count(black), 0) << "labels";
    EXPECT_EQ(scale.count(colorOf(missError)) > 0, width >= 500) << width;
  }
}

TEST(ErrorPicture, QuadIsMarkedWhereItsSizeIsOnTheScale) {
  const ImageSize size{480, 10};
  const ScaleOf none(size, 0.0f);
  const auto [first, last] = none.bar();
  for (float pixels : {0.0001f, 0.5f, 1.7f, 4.0f}) {
    const ScaleOf scale(size, pixels);
    const int at = first + int(float(last + 1 - first) * pixels / 5);
    EXPECT_GE(scale.count(black, at, at + 1), none.count(black, at, at + 1) + 8) << pixels;
  }
  const ScaleOf large(size, 12.0f);
  EXPECT_GT(large.count(black), none.count(black)) << "a label";
}

TEST(ErrorPicture, SmallPicturesLeaveLabelsOut) {
  for (int width : {1, 2, 15, 16, 17, 30, 60, 100})
    for (float quad : {0.0f, 0.5f, 1e30f})
      EXPECT_GT(errorPicture({width, 1}, std::vector<float>(size_t(width), 1.0f), quad).size.height, 1);
}

TEST(QuadSize, IsTheLengthOfAnEdgeInPixels) {
  const ImageSize size{40, 30};
  std::vector<SurfaceHit> hits(size_t(size.width * size.height));
  for (int y = 0; y < size.height; y++)
    for (int x = 0; x < size.width; x++) {
      SurfaceHit& hit = hits[size_t(y * size.width + x)];
      hit.face = x < 20 ? 3 : 4;
      hit.t = y < 25 ? 1.0f : INFINITY;
      hit.u = 0.01f * float(x + y); // turned by 45 degrees
      hit.v = 0.01f * float(x - y);
    }
  EXPECT_NEAR(medianQuadSize(size, hits, 0), 100 / std::sqrt(2.0f), 0.1f);
  EXPECT_NEAR(medianQuadSize(size, hits, 5), 100 / std::sqrt(2.0f) / 32, 0.01f);
  for (size_t i = 0; i < hits.size(); i++) hits[i].face = unsigned(i);
  EXPECT_EQ(medianQuadSize(size, hits, 5), 0.0f) << "faces are smaller than pixels";
}

}} // namespace programs::test
