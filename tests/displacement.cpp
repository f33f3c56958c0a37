// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "displacement.h"
#include "scenes/cube.h"

#include <gtest/gtest.h>

namespace cbvh {
namespace {

/* Two quads beside each other, one atlas over both: face 0 left, face 1 right. */
Cage twoQuads()
{
  Cage cage;
  cage.name = "two";
  cage.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
  cage.faceSizes = {4, 4};
  cage.faceIndices = {0, 1, 4, 3, 1, 2, 5, 4};
  cage.uvs = {{0.1f, 0.1f}, {0.45f, 0.13f}, {0.9f, 0.1f}, {0.1f, 0.9f}, {0.55f, 0.87f}, {0.9f, 0.9f}};
  cage.uvIndices = cage.faceIndices;
  return cage;
}

HeightMap ramp(int size)
{
  HeightMap map(size, size);
  for (int y = 0; y < size; y++)
    for (int x = 0; x < size; x++)
      map.at(x, y) = std::sin(0.7f * float(x)) * std::cos(0.3f * float(y));
  return map;
}

float offset(const Displacement& d, unsigned face, float u, float v)
{
  float result;
  d.offsets(face, 1, &u, &v, &result);
  return result;
}

TEST(Displacement, FacesWithTheSameCoordinatesOnAnEdgeMeetExactly)
{
  const Cage cage = twoQuads();
  const auto d = displaceByUVs(cage, ramp(64), 2.0f);
  for (int i = 0; i <= 256; i++) // right border of face 0, left border of face 1
    EXPECT_EQ(offset(*d, 0, 1.0f, float(i) / 256), offset(*d, 1, 0.0f, float(i) / 256)) << i;
}

TEST(Displacement, NeutralHeightMovesNothing)
{
  HeightMap map(4, 4);
  for (int y = 0; y < 4; y++)
    for (int x = 0; x < 4; x++)
      map.at(x, y) = neutralHeight;
  const Cage cage = twoQuads();
  EXPECT_EQ(offset(*displaceByUVs(cage, map, 3.0f), 1, 0.3f, 0.7f), 0.0f);
  EXPECT_EQ(offset(*displaceByFace(cage, map, 3.0f), 1, 0.3f, 0.7f), 0.0f);
  EXPECT_EQ(offset(*displaceByAtlas(FaceAtlas::forFaces(1, 2), map, 3.0f), 0, 0.3f, 0.7f), 0.0f);
}

TEST(Displacement, PolygonsInterpolateOverTheirCornerQuads)
{
  /* Height = s: what comes back is the first texture coordinate. */
  Cage triangle;
  triangle.name = "triangle";
  triangle.faceSizes = {3};
  triangle.faceIndices = {0, 1, 2};
  triangle.uvs = {{0.2f, 0.5f}, {0.8f, 0.5f}, {0.5f, 0.5f}};
  triangle.uvIndices = {0, 1, 2};
  HeightMap map(101, 1);
  for (int x = 0; x < 101; x++)
    map.at(x, 0) = (float(x) + 0.5f) / 101.0f + neutralHeight;
  const auto d = displaceByUVs(triangle, map, 1.0f);
  EXPECT_NEAR(offset(*d, 0, 0.5f, 0.5f), 0.2f, 1e-5f);  // corner 0
  EXPECT_NEAR(offset(*d, 0, 1.5f, 0.5f), 0.5f, 1e-5f);  // middle of its edge
  EXPECT_NEAR(offset(*d, 0, 2.5f, 0.5f), 0.8f, 1e-5f);  // corner 1
  EXPECT_NEAR(offset(*d, 0, 1.5f, 1.5f), 0.5f, 1e-5f);  // centre, from corner 0
  EXPECT_NEAR(offset(*d, 0, 3.5f, 1.5f), 0.5f, 1e-5f);  // and from corner 1
}

TEST(Displacement, AtlasTilesAreReadAtTheirOwnTexelsExactly)
{
  const FaceAtlas atlas = FaceAtlas::forFaces(7, 8);
  HeightMap map(atlas.columns(), atlas.rows(7));
  for (int y = 0; y < map.height(); y++)
    for (int x = 0; x < map.width(); x++)
      map.at(x, y) = float(y * map.width() + x);
  const auto d = displaceByAtlas(atlas, map, 1.0f);
  for (int face = 0; face < 7; face++)
    for (int y = 0; y <= 8; y++)
      for (int x = 0; x <= 8; x++)
      {
        const int column = face % atlas.tilesPerRow * 9 + x, row = face / atlas.tilesPerRow * 9 + y;
        EXPECT_EQ(offset(*d, unsigned(face), float(x) / 8, float(y) / 8), map.at(column, row) - neutralHeight);
      }
}

TEST(Displacement, CubeSpikesVanishOnTheBorders)
{
  const Model cube = makeCube();
  for (int i = 0; i <= 64; i++)
    for (auto [u, v] : {std::pair<float, float>{0, i / 64.0f}, {1, i / 64.0f}, {i / 64.0f, 0}, {i / 64.0f, 1}})
      EXPECT_NEAR(offset(*cube.displacement, 2, u, v), 0.0f, 1e-12f);
  EXPECT_NEAR(offset(*cube.displacement, 2, 0.5f, 0.5f), cubeAmplitude * cube.cage.bounds().diagonal(), 1e-6f);
}

} // namespace
} // namespace cbvh
