// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays that start at an application's own samples of a raster with walls, as docs/terrain.md describes: samples whose x
 * and y are multiples of the spacing are never below the stored surface. */

#include <cbvh/cbvh.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace programs::test { namespace {

constexpr int side = 201; // samples

/* Houses of 5 to 20 units, in blocks without a common period. */
float houseAt(int x, int y) { return x % 17 < 8 && y % 13 < 7 ? float(5 + (x / 17 * 7 + y / 13 * 3) % 16) : 0.0f; }

class Raster {
public:
  /* step: between samples along x and y. maxError: 0 for the default. */
  Raster(double step, double origin, float maxError, const std::function<float(int x, int y)>& heightAt) {
    for (int y = 0; y < side; y++)
      for (int x = 0; x < side; x++)
        for (const float value : {float(origin + step * x), float(origin + step * y), heightAt(x, y)})
          vertices.push_back(value);
    vertices.push_back(0); // padding that may be read
    const CbvhGrid grid = {0, side, side, side};
    const float* const steps[1] = {vertices.data()};
    CbvhGrids grids = CbvhGrids();
    grids.numGrids = 1;
    grids.grids = &grid;
    grids.vertices = {size_t(side) * side, 3 * sizeof(float), steps, 1, 0, 0};
    CbvhAccuracy accuracy = CbvhAccuracy();
    accuracy.maxError = maxError;
    EXPECT_EQ(cbvhNewContext(nullptr, nullptr, nullptr, &context), CBVH_OK);
    EXPECT_EQ(cbvhNewSurface(context, &surface), CBVH_OK);
    EXPECT_EQ(cbvhSetSurfaceAccuracy(surface, &accuracy), CBVH_OK);
    EXPECT_EQ(cbvhSetSurfaceGrids(surface, &grids), CBVH_OK);
    EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK);
    EXPECT_EQ(cbvhNewGroup(context, &surface, 1, &group), CBVH_OK);
    EXPECT_EQ(cbvhCommitGroup(group), CBVH_OK);
    EXPECT_EQ(cbvhGetGroupStatistics(group, &statistics), CBVH_OK);
  }
  ~Raster() {
    cbvhReleaseGroup(group);
    cbvhReleaseSurface(surface);
    cbvhReleaseContext(context);
  }
  Raster(const Raster&) = delete;
  Raster& operator=(const Raster&) = delete;

  /* Samples for which a vertical ray from `above` over the sample hits the stored surface. */
  size_t numBelowSurface(double above) const {
    size_t count = 0;
    for (size_t i = 0; i < size_t(side) * side; i++) {
      CbvhRay ray{};
      ray.org_x = vertices[3 * i];
      ray.org_y = vertices[3 * i + 1];
      ray.org_z = float(double(vertices[3 * i + 2]) + above);
      ray.dir_z = 1;
      ray.tfar = INFINITY;
      ray.mask = ~0u;
      count += cbvhOccluded1(group, &ray, nullptr) != 0;
    }
    return count;
  }

  float moved() const { return statistics.maxVertexDeviation; }

private:
  std::vector<float> vertices;
  CbvhContext context = nullptr;
  CbvhSurface surface = nullptr;
  CbvhGroup group = nullptr;
  CbvhGroupStatistics statistics = CbvhGroupStatistics();
};

TEST(OwnSamples, RaysStartAtSamplesOnTheLatticeAtTheDefaultPrecision) {
  for (const double cell : {0.25, 1.0, 2.0, 30.0}) {
    const Raster raster(cell, -64 * cell, 0, [=](int x, int y) { return float(cell) * (houseAt(x, y) + 0.137f * x); });
    EXPECT_EQ(raster.numBelowSurface(cell / 1000), 0u) << cell;
    EXPECT_LE(raster.moved(), cell / 1024) << "x and y do not move";
  }
}

/* The same raster with cells of 0.2, in coordinates that docs/terrain.md recommends. */
TEST(OwnSamples, CountedColumnsAndRowsNeverMove) {
  const auto heightAt = [](int x, int y) { return houseAt(x, y) + 0.0137f * x; };
  EXPECT_GT(Raster(0.2, 0, 0, heightAt).numBelowSurface(0.002), 0u) << "otherwise this test shows nothing";
  EXPECT_EQ(Raster(1, 0, 0, heightAt).numBelowSurface(0.002), 0u);
  EXPECT_EQ(Raster(1, 0, 0, [&](int x, int y) { return heightAt(x, y) / 0.2f; }).numBelowSurface(0.01), 0u);
}

/* How cbvh_terrain stores heights at any error bound. */
TEST(OwnSamples, MultiplesOfTheSpacingDoNotMove) {
  for (const float maxError : {0.3f, 0.1f, 1.0f / 64}) {
    const float spacing = std::ldexp(1.0f, std::ilogb(maxError));
    const Raster raster(1, 0, maxError, [=](int x, int y) {
      return std::round((houseAt(x, y) + 0.0137f * float(x)) / spacing) * spacing;
    });
    EXPECT_EQ(raster.moved(), 0.0f) << maxError;
    EXPECT_EQ(raster.numBelowSurface(1e-4), 0u) << maxError;
  }
}

}} // namespace programs::test
