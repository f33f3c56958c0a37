// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/cage_validation.h"
#include "basics/error.h"
#include "scenes/cube.h"

#include <gtest/gtest.h>

namespace cbvh::test {
namespace {

Cage withFaces(size_t vertices, const std::vector<std::vector<unsigned>>& faces)
{
  Cage cage;
  cage.name = "test";
  for (size_t i = 0; i < vertices; i++)
    cage.positions.push_back({float(i), float(i * i), 0});
  for (const auto& face : faces)
  {
    cage.faceSizes.push_back(unsigned(face.size()));
    cage.faceIndices.insert(cage.faceIndices.end(), face.begin(), face.end());
  }
  return cage;
}

std::string errorOf(const Cage& cage)
{
  try
  {
    validateCage(cage);
  }
  catch (const Error& e)
  {
    return e.what();
  }
  return "";
}

TEST(CageValidation, AcceptsClosedAndOpenCages)
{
  EXPECT_EQ(errorOf(makeCube().cage), "");
  EXPECT_EQ(errorOf(withFaces(4, {{0, 1, 2, 3}})), "");
  EXPECT_EQ(errorOf(withFaces(5, {{0, 1, 2, 3}, {1, 0, 4}})), "");
}

TEST(CageValidation, NamesAnEdgeOfThreeFaces)
{
  const std::string error = errorOf(withFaces(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}));
  EXPECT_NE(error.find("not manifold: the edge from vertex 1 to 2"), std::string::npos) << error;
}

TEST(CageValidation, NamesFacesThatDisagreeOnTheirSide)
{
  const std::string error = errorOf(withFaces(4, {{0, 1, 2}, {0, 1, 3}}));
  EXPECT_NE(error.find("not manifold"), std::string::npos) << error;
}

TEST(CageValidation, RefusesRepeatedVerticesAndLargeFaces)
{
  EXPECT_EQ(errorOf(withFaces(3, {{0, 1, 1}})), "test: face 1 names vertex 2 twice");
  std::vector<unsigned> ring(17);
  for (unsigned i = 0; i < 17; i++)
    ring[i] = i;
  EXPECT_EQ(errorOf(withFaces(17, {ring})), "test: face 1 has 17 vertices, Embree takes at most 16");
}

TEST(CageValidation, RefusesTooManyFacesAroundAVertex)
{
  std::vector<std::vector<unsigned>> fan;
  for (unsigned i = 0; i < 65; i++)
    fan.push_back({0, 1 + i, 1 + (i + 1) % 65});
  EXPECT_EQ(errorOf(withFaces(66, fan)), "test: vertex 1 has 65 faces around it, Embree takes at most 64");
}

} // namespace
} // namespace cbvh::test
