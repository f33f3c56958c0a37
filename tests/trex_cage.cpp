// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "cage_validation.h"
#include "scenes/trex.h"

#include <gtest/gtest.h>

#include <map>

namespace cbvh {
namespace {

TEST(TrexCage, IsAClosedManifoldOfSixToEightThousandQuads)
{
  const Cage cage = makeTrexCage();
  EXPECT_GE(cage.numFaces(), 6000u);
  EXPECT_LE(cage.numFaces(), 8000u);
  EXPECT_NO_THROW(validateCage(cage));
  std::map<std::pair<unsigned, unsigned>, int> halfEdges;
  for (size_t f = 0; f < cage.numFaces(); f++)
  {
    ASSERT_EQ(cage.faceSizes[f], 4u);
    for (int i = 0; i < 4; i++)
      halfEdges[{cage.faceIndices[4 * f + i], cage.faceIndices[4 * f + (i + 1) % 4]}]++;
  }
  for (const auto& [edge, count] : halfEdges)
  {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(halfEdges.count({edge.second, edge.first})) << "a boundary";
  }
}

TEST(TrexCage, FacesOutwardsAndHasManyExtraordinaryVertices)
{
  const Cage cage = makeTrexCage();
  double volume = 0; // by the divergence theorem, positive when faces look outwards
  std::vector<int> valence(cage.positions.size());
  for (size_t f = 0; f < cage.numFaces(); f++)
  {
    const unsigned* q = &cage.faceIndices[4 * f];
    const Vec3f a = cage.positions[q[0]], b = cage.positions[q[1]], c = cage.positions[q[2]], d = cage.positions[q[3]];
    volume += dot(a, cross(b, c)) + dot(a, cross(c, d));
    for (int i = 0; i < 4; i++)
      valence[q[i]]++;
  }
  EXPECT_GT(volume / 6, 5.0);
  size_t extraordinary = 0;
  for (int v : valence)
    extraordinary += v != 4;
  EXPECT_GT(extraordinary, 1000u);
}

} // namespace
} // namespace cbvh
