// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/cage_validation.h"
#include "surface/crease_rules.h"
#include "basics/error.h"
#include "scenes/cube.h"
#include "support/message_parts.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace programs::test { namespace {

Cage withFaces(size_t vertices, const std::vector<std::vector<unsigned>>& faces) {
  Cage cage;
  cage.name = "test";
  for (size_t i = 0; i < vertices; i++) cage.positions.push_back({float(i), float(i * i), 0});
  for (const auto& face : faces) {
    cage.faceSizes.push_back(unsigned(face.size()));
    cage.faceIndices.insert(cage.faceIndices.end(), face.begin(), face.end());
  }
  return cage;
}

std::string errorOf(Cage cage) {
  try {
    std::string warnings;
    validateCage(cage, warnings);
  } catch (const Error& e) { return e.what(); }
  return "";
}

struct Checked {
  Cage cage;
  std::string warnings;
};

Checked checked(Cage cage) {
  Checked result{std::move(cage), ""};
  validateCage(result.cage, result.warnings);
  return result;
}

ptrdiff_t linesOf(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

/* A closed fan of triangles around vertex 0. */
std::vector<std::vector<unsigned>> fan(unsigned n) {
  std::vector<std::vector<unsigned>> faces;
  for (unsigned i = 0; i < n; i++) faces.push_back({0, 1 + i, 1 + (i + 1) % n});
  return faces;
}

TEST(CageValidation, AcceptsClosedAndOpenCages) {
  EXPECT_EQ(checked(makeCube().cage).warnings, "");
  EXPECT_EQ(checked(withFaces(4, {{0, 1, 2, 3}})).warnings, "");
  EXPECT_EQ(checked(withFaces(5, {{0, 1, 2, 3}, {1, 0, 4}})).warnings, "");
}

TEST(CageValidation, WarnsOfACageWithoutExtent) {
  Cage cage = withFaces(4, {{0, 1, 2, 3}});
  EXPECT_EQ(checked(cage).warnings, "");
  cage.positions.assign(4, {1, 2, 3});
  EXPECT_TRUE(containsInOrder(checked(cage).warnings, {"test: ", "position", "\n"}));
}

TEST(CageValidation, WarnsOfAnEdgeOfThreeFaces) {
  const Checked result = checked(withFaces(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}));
  EXPECT_TRUE(containsInOrder(result.warnings, {"test: ", "1 edge", " 1 ", " 2 ", "3 faces"}));
  EXPECT_TRUE(result.cage.holes.empty());
}

TEST(CageValidation, WarnsOfFacesWithOppositeOrientation) {
  const Checked result = checked(withFaces(4, {{0, 1, 2}, {0, 1, 3}}));
  EXPECT_TRUE(containsInOrder(result.warnings, {"test: ", "1 edge", " 1 ", " 2 ", "2 faces"}));
}

TEST(CageValidation, RejectsRepeatedVertices) {
  EXPECT_TRUE(containsInOrder(errorOf(withFaces(3, {{0, 1, 1}})), {"test: ", "face 1 ", "vertex 2 "}));
}

TEST(CageValidation, CutsOutLargeFaces) {
  std::vector<unsigned> ring(17);
  for (unsigned i = 0; i < 17; i++) ring[i] = i;
  const Checked result = checked(withFaces(18, {{1, 0, 17}, ring}));
  EXPECT_EQ(result.cage.holes, (std::vector<unsigned>{1}));
  EXPECT_TRUE(containsInOrder(result.warnings, {"test: ", "face 2 ", " 17 ", " 16"}));
  EXPECT_EQ(linesOf(result.warnings), 1);
  const std::string several = checked(withFaces(18, {{1, 0, 17}, ring, ring, ring})).warnings;
  EXPECT_TRUE(containsInOrder(several, {"test: ", "face 2 ", " 17 ", " 2 ", " 16"}));
  EXPECT_EQ(several.rfind("face 2 "), several.find("face 2 "));
  EXPECT_TRUE(containsInOrder(errorOf(withFaces(17, {ring})), {"test: ", " 16 ", " 1024 "}));
}

TEST(CageValidation, RepeatedHolesCountOnce) {
  Cage cage = withFaces(6, {{0, 1, 2, 3}, {1, 4, 5, 2}});
  cage.holes = {0, 0};
  EXPECT_TRUE(containsInOrder(checked(cage).warnings, {"test: ", "1 hole", "face 1:"}));
  cage.holes = {0, 1, 1};
  EXPECT_TRUE(containsInOrder(errorOf(cage), {"test: ", " 16 ", " 1024 "}));
}

TEST(CageValidation, CutsOutFacesAroundAVertexWithTooMany) {
  std::vector<std::vector<unsigned>> faces = fan(1025);
  faces.push_back({2, 1, 1026});
  const Checked result = checked(withFaces(1027, faces));
  EXPECT_EQ(result.cage.holes.size(), 1025u);
  EXPECT_TRUE(containsInOrder(result.warnings, {"test: ", "vertex 1 ", " 1025 ", " 1024"}));
  EXPECT_EQ(linesOf(result.warnings), 1);
  EXPECT_EQ(checked(withFaces(1025, fan(1024))).warnings, "");
  for (std::vector<unsigned> face : fan(1030)) // a second fan
  {
    for (unsigned& v : face) v += 1027;
    faces.push_back(face);
  }
  const std::string both = checked(withFaces(2058, faces)).warnings;
  EXPECT_TRUE(containsInOrder(both, {"test: ", "vertex 1 ", " 1025 ", " 1 ", " 1024"}));
  EXPECT_EQ(linesOf(both), 1);
}

TEST(CageValidation, CountsFacesAroundAVertexLikeEmbree) {
  std::vector<std::vector<unsigned>> fins; // 70 triangles at one edge; each of them has a vertex of its own
  for (unsigned i = 0; i < 70; i++) fins.push_back({0, 1, 2 + i});
  const Checked result = checked(withFaces(72, fins));
  EXPECT_TRUE(result.cage.holes.empty());
  EXPECT_TRUE(containsInOrder(result.warnings, {"test: ", "1 edge", " 1 ", " 2 ", "70 faces"}));
}

TEST(CageValidation, WarnsOfAVertexThatJoinsPartsWithoutAnEdge) {
  const Checked result = checked(withFaces(5, {{0, 1, 2}, {0, 3, 4}}));
  EXPECT_TRUE(containsInOrder(result.warnings, {"test: ", "manifold", "1 vertex", "vertex 1 "}));
  EXPECT_EQ(linesOf(result.warnings), 1);
}

/* Four quads around vertex 4, with creases at it. */
Cage creasedQuads(const std::vector<float>& sharpness) {
  Cage cage = withFaces(9, {{0, 1, 4, 3}, {1, 2, 5, 4}, {3, 4, 7, 6}, {4, 5, 8, 7}});
  const std::pair<unsigned, unsigned> edges[] = {{1, 4}, {4, 7}, {3, 4}, {4, 5}};
  for (size_t i = 0; i < sharpness.size(); i++) {
    cage.creaseEdges.push_back(edges[i]);
    cage.creaseSharpness.push_back(sharpness[i]);
  }
  return cage;
}

/* n x n quads, without what is at the border of the unit squares. */
Cage quads(unsigned n) {
  std::vector<std::vector<unsigned>> faces;
  for (unsigned y = 0; y < n; y++)
    for (unsigned x = 0; x < n; x++) {
      const unsigned v = y * (n + 1) + x;
      faces.push_back({v, v + 1, v + n + 2, v + n + 1});
    }
  return withFaces((n + 1) * (n + 1), faces);
}

void crease(Cage& cage, unsigned face, float sharpness) {
  for (unsigned i = 0; i < 4; i++)
    cage.creaseEdges.push_back({cage.faceIndices[4 * face + i], cage.faceIndices[4 * face + (i + 1) % 4]});
  cage.creaseSharpness.assign(cage.creaseEdges.size(), sharpness);
}

/* See docs/renderers.md. With an infinite crease around a hole, both programs agree. */
TEST(CageValidation, WarnsOfHolesThatOpenSubdivSmooths) {
  Cage cage = quads(5);
  EXPECT_EQ(checked(cage).warnings, "");
  cage.holes = {6};
  EXPECT_TRUE(containsInOrder(checked(cage).warnings, {"test: ", "1 hole", "face 7:"}));
  EXPECT_EQ(linesOf(checked(cage).warnings), 1);
  cage.holes = {6, 18};
  EXPECT_TRUE(containsInOrder(checked(cage).warnings, {"test: ", "2 holes", "face 7:"}));
  crease(cage, 6, 3.0f);
  EXPECT_TRUE(containsInOrder(checked(cage).warnings, {"2 holes"}));
  cage.creaseEdges.clear();
  crease(cage, 6, INFINITY);
  EXPECT_TRUE(containsInOrder(checked(cage).warnings, {"1 hole", "face 19:"}));
  crease(cage, 18, INFINITY);
  EXPECT_EQ(checked(cage).warnings, "");
  Cage all = quads(1);
  all.holes = {0};
  EXPECT_NE(errorOf(all), "");
}

/* Counted by Embree's hits in a sheet of 6 x 6: of 16 faces within, a hole leaves 7. */
TEST(CageValidation, WarnsOfFacesThatVanishWithoutBoundary) {
  Cage cage = quads(6);
  cage.boundary = BoundaryRule::None;
  EXPECT_EQ(checked(cage).warnings, "") << "OpenSubdiv leaves out the same faces";
  Cage holed = cage;
  holed.holes = {14};
  EXPECT_TRUE(containsInOrder(checked(holed).warnings, {"test: ", "8 faces", "rule 0"}));
  EXPECT_EQ(linesOf(checked(holed).warnings), 1);
  for (unsigned y = 0; y < 6; y++)
    for (unsigned x = 0; x < 6; x++)
      if (x == 0 || y == 0 || x == 5 || y == 5) crease(cage, 6 * y + x, INFINITY);
  EXPECT_TRUE(containsInOrder(checked(cage).warnings, {"test: ", "20 faces", "rule 0"}));
}

TEST(CageValidation, IgnoresCreasesWithoutEdge) {
  Cage cage = creasedQuads({2.0f, 2.0f});
  cage.creaseEdges.insert(cage.creaseEdges.begin(), {{4, 0}, {5, 8}, {6, 2}});
  cage.creaseSharpness.insert(cage.creaseSharpness.begin(), {1.0f, 3.0f, 4.0f});
  const Checked result = checked(cage);
  EXPECT_TRUE(containsInOrder(result.warnings, {"test: ", "crease", "vertices 5 and 1,", " edge", " 1 other"}));
  EXPECT_EQ(linesOf(result.warnings), 1);
  EXPECT_EQ(result.cage.creaseEdges.size(), 3u);
  EXPECT_EQ(result.cage.creaseSharpness, (std::vector<float>{3.0f, 2.0f, 2.0f}));
}

TEST(CageValidation, WarnsIfEmbreesRuleForCreasesDiffers) {
  const auto isNamed = [](const Cage& cage) {
    const std::vector<unsigned> vertices = findVerticesWithDifferentCreaseRules(cage);
    return std::find(vertices.begin(), vertices.end(), 4u) != vertices.end();
  };
  EXPECT_FALSE(isNamed(creasedQuads({1.5f})));
  EXPECT_FALSE(isNamed(creasedQuads({1.5f, 1.5f})));
  EXPECT_TRUE(isNamed(creasedQuads({1.0f, 2.0f})));
  EXPECT_FALSE(isNamed(creasedQuads({1.0f, 2.0f, 2.0f}))) << "whole numbers";
  EXPECT_TRUE(isNamed(creasedQuads({0.1f, 5.0f, 5.0f})));
  EXPECT_TRUE(isNamed(creasedQuads({1.0f, 2.0f, 3.0f}))) << "two of them remain";
  const Cage uneven = creasedQuads({0.1f, 5.0f, 5.0f});
  const std::string vertex = std::to_string(findVerticesWithDifferentCreaseRules(uneven).front() + 1);
  EXPECT_TRUE(containsInOrder(checked(uneven).warnings, {"test: ", "crease", " " + vertex + ",", "rule"}));
  Cage cornered = creasedQuads({2.0f, 2.0f});
  cornered.cornerVertices = {4};
  cornered.cornerSharpness = {1.0f};
  EXPECT_TRUE(isNamed(cornered));
  Cage chaikin = creasedQuads({1.0f, 2.0f});
  chaikin.creaseRule = CreaseRule::Chaikin;
  EXPECT_FALSE(isNamed(chaikin)) << "Embree's own rule";
}

}} // namespace programs::test
