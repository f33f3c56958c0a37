// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/up_axis.h"
#include "scenes/cube.h"
#include "scenes/frog.h"
#include "scenes/knee.h"
#include "scenes/scythe.h"
#include "scenes/trex_cage.h"
#include "surface/obj_reader.h"

#include <gtest/gtest.h>

#include <sstream>

namespace programs::test { namespace {

/* --- shapes with y up, standing on y = 0, facing z ----------------------------------------- */

void addBox(Cage& cage, Vec3f lower, Vec3f upper) {
  const unsigned first = unsigned(cage.positions.size());
  for (unsigned i = 0; i < 8; i++)
    cage.positions.push_back({i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z});
  for (const unsigned i : {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5})
    cage.faceIndices.push_back(first + i);
  cage.faceSizes.insert(cage.faceSizes.end(), 6, 4);
}

/* Rings of 16 vertices around the y axis. */
Cage turnedOnALathe(const std::vector<Vec2f>& radiusAndHeight) {
  constexpr unsigned n = 16;
  Cage cage;
  for (const Vec2f ring : radiusAndHeight)
    for (unsigned i = 0; i < n; i++) {
      const float angle = 2.0f * float(M_PI) * float(i) / float(n);
      cage.positions.push_back({ring.x * std::cos(angle), ring.y, ring.x * std::sin(angle)});
    }
  for (unsigned r = 0; r + 1 < radiusAndHeight.size(); r++)
    for (unsigned i = 0; i < n; i++) {
      const unsigned j = (i + 1) % n;
      for (const unsigned v : {r * n + i, r * n + n + i, r * n + n + j, r * n + j}) cage.faceIndices.push_back(v);
      cage.faceSizes.push_back(4);
    }
  return cage;
}

Cage pawn() { return turnedOnALathe({{1, 0}, {1, 0.3f}, {0.4f, 0.8f}, {0.3f, 1.8f}, {0.6f, 2.2f}, {0.3f, 2.8f}}); }
Cage glass() { return turnedOnALathe({{0.8f, 0}, {0.1f, 0.1f}, {0.1f, 1.5f}, {0.9f, 2.2f}, {0.8f, 3.2f}}); }

Cage table() {
  Cage cage;
  addBox(cage, {-1, 1, -0.8f}, {1, 1.1f, 0.8f});
  for (const float x : {-0.9f, 0.8f})
    for (const float z : {-0.7f, 0.6f}) addBox(cage, {x, 0, z}, {x + 0.1f, 1, z + 0.1f});
  return cage;
}

Cage chair() {
  Cage cage;
  addBox(cage, {-0.5f, 0.5f, -0.5f}, {0.5f, 0.6f, 0.5f});
  addBox(cage, {-0.5f, 0.6f, -0.5f}, {0.5f, 1.3f, -0.4f});
  for (const float x : {-0.5f, 0.4f})
    for (const float z : {-0.5f, 0.4f}) addBox(cage, {x, 0, z}, {x + 0.1f, 0.5f, z + 0.1f});
  return cage;
}

/* A person: feet that extend to the front, arms to the sides, a nose. */
Cage person() {
  Cage cage;
  for (const float side : {-1.0f, 1.0f}) {
    const auto pair = [&](Vec3f inner, Vec3f outer) {
      const float a = side * inner.x, b = side * outer.x;
      addBox(cage, {std::min(a, b), inner.y, inner.z}, {std::max(a, b), outer.y, outer.z});
    };
    pair({0.06f, 0, -0.1f}, {0.18f, 0.08f, 0.2f});
    pair({0.06f, 0.08f, -0.08f}, {0.18f, 0.9f, 0.06f});
    pair({0.2f, 1.35f, -0.05f}, {0.85f, 1.45f, 0.05f});
  }
  addBox(cage, {-0.2f, 0.9f, -0.12f}, {0.2f, 1.5f, 0.12f});
  addBox(cage, {-0.1f, 1.55f, -0.1f}, {0.1f, 1.8f, 0.12f});
  addBox(cage, {-0.02f, 1.64f, 0.12f}, {0.02f, 1.68f, 0.16f});
  return cage;
}

Cage dog() {
  Cage cage;
  addBox(cage, {-0.15f, 0.4f, -0.5f}, {0.15f, 0.7f, 0.5f});
  addBox(cage, {-0.1f, 0.65f, 0.5f}, {0.1f, 0.9f, 0.8f});
  addBox(cage, {-0.03f, 0.6f, -0.8f}, {0.03f, 0.7f, -0.5f});
  for (const float x : {-0.15f, 0.05f})
    for (const float z : {-0.45f, 0.35f}) addBox(cage, {x, 0, z}, {x + 0.1f, 0.4f, z + 0.1f});
  return cage;
}

/* --- shapes that are not z up although their lowest z is 0 ------------------------------------ */

Cage mask() // open and flat at its back; a nose
{
  Cage cage = turnedOnALathe({{1, 0}, {0.9f, 0.4f}, {0.5f, 0.7f}, {0.2f, 0.8f}});
  for (Vec3f& p : cage.positions) p = {0.8f * p.x, -p.z * (p.z > 0 ? 1.3f : 1.0f), p.y};
  return cage;
}

Cage gun() {
  Cage cage;
  addBox(cage, {-0.03f, -0.08f, 0}, {0.03f, 0.08f, 0.3f});
  addBox(cage, {-0.02f, 0, 0.3f}, {0.02f, 0.05f, 1});
  addBox(cage, {-0.02f, -0.2f, 0.25f}, {0.02f, -0.08f, 0.3f});
  return cage;
}

Cage shield() // its back on a wall
{
  Cage cage;
  addBox(cage, {-1, -1, 0}, {1, 1, 0.1f});
  addBox(cage, {-0.3f, -0.3f, 0.1f}, {0.3f, 0.3f, 0.3f});
  return cage;
}

Cage sword() // lying on the ground
{
  Cage cage;
  addBox(cage, {-0.1f, -0.02f, 0}, {0.1f, 0.02f, 1});
  addBox(cage, {-0.04f, -0.01f, 1}, {0.04f, 0.01f, 4});
  return cage;
}

/* --- rotated -------------------------------------------------------------------------------- */

template<typename Turn>
Cage moved(Cage cage, const Turn& turn) {
  for (Vec3f& p : cage.positions) p = turn(p);
  return cage;
}

Vec3f toZ(Vec3f p) { return {p.x, -p.z, p.y}; } // z up, facing -y, as in Blender

const std::pair<const char*, Cage (*)()> standing[] = {
    {"pawn", pawn}, {"glass", glass}, {"table", table}, {"person", person}, {"dog", dog}};

TEST(UpAxis, IsYForShapesStandingOnY) {
  for (const auto& [name, make] : standing) {
    EXPECT_EQ(guessUp(make()).axis, "y") << name;
    EXPECT_EQ(guessUp(moved(make(), [](Vec3f p) { return Vec3f{p.z, p.y, -p.x}; })).axis, "y")
        << name << " looking along x";
    EXPECT_EQ(guessUp(moved(make(), [](Vec3f p) { return Vec3f{-p.x, p.y, -p.z}; })).axis, "y")
        << name << " looking back";
    EXPECT_EQ(guessUp(moved(make(), [](Vec3f p) { return p + Vec3f{0, -0.5f, 0}; })).axis, "y") << name << " sunken";
    EXPECT_EQ(guessUp(moved(make(), [](Vec3f p) { return p + Vec3f{3, 0, 2}; })).axis, "y") << name << " elsewhere";
    EXPECT_EQ(guessUp(make()).reason, "") << name;
  }
}

TEST(UpAxis, IsZForShapesStandingOnZ) {
  for (const auto& [name, make] : standing) {
    const UpGuess guess = guessUp(moved(make(), toZ));
    EXPECT_EQ(guess.axis, "z") << name;
    EXPECT_NE(guess.reason.find("z = 0"), std::string::npos) << name << ": " << guess.reason;
  }
}

TEST(UpAxis, IsYIfAmbiguous) {
  const std::pair<const char*, Cage> shapes[] = {
      {"mask", mask()},
      {"gun", gun()},
      {"shield", shield()},
      {"sword", sword()},
      {"chair", chair()},
      {"chair that could lie on its front", moved(chair(), toZ)},
      {"person upside down in z", moved(person(), [](Vec3f p) { return Vec3f{p.x, p.z, -p.y}; })},
      {"person in the air", moved(moved(person(), toZ), [](Vec3f p) { return p + Vec3f{0, 0, 0.5f}; })}};
  for (const auto& [name, cage] : shapes) EXPECT_EQ(guessUp(cage).axis, "y") << name << ": " << guessUp(cage).reason;
  Cage flat;
  flat.positions = {{0, -1, 0}, {1, -1, 0}, {1, 1, 0}, {0, 1, 0}};
  flat.faceIndices = {0, 1, 2, 3};
  flat.faceSizes = {4};
  EXPECT_EQ(guessUp(flat).axis, "y");
}

TEST(UpAxis, IsYForAllCagesThatProgramsMake) {
  for (const Cage& cage : {makeCube(0.1f).cage, makeFrog(0.1f, 0).cage, makeKnee(0.1f, 0).cage,
                           makeScythe(0.1f, 0).cage, makeTrexCage().cage})
    EXPECT_EQ(guessUp(cage).axis, "y") << guessUp(cage).reason;
}

TEST(UpAxis, ConsidersFacesOnly) {
  Cage cage = moved(pawn(), toZ);
  cage.positions.push_back({7, 8, -9});
  EXPECT_EQ(guessUp(cage).axis, "z");
}

/* --- comments --------------------------------------------------------------------------------- */

std::string upOf(const std::string& comments) {
  std::istringstream stream(comments + "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n# z up\n");
  std::string warnings;
  return guessUp(readObj(stream, "test.obj", warnings)).axis;
}

TEST(UpAxis, IsReadFromTheHeadOfTheFile) {
  for (const char* z :
       {"# Z up\n", "# z-up\n", "# Up axis: Z\n", "# made by hand\n#up=z\n", "# forward -Y, up Z\n", "# ZUP\n",
        "# Z axis up\n", "# OpenSCAD obj exporter\n", "# FreeCAD v0.20 build29177 Arch module\n"})
    EXPECT_EQ(upOf(z), "z") << z;
  for (const char* y :
       {"", "# Y up\n", "# Blender 3.6.0\n# www.blender.org\n", "# forward -Z, up Y\n", "# -Z forward, Y up\n",
        "# scaled up\n", "# z up or y up\n", "# 3ds Max Wavefront OBJ Exporter\n", "#\n", "# FreeCAD v0.20, y up\n"})
    EXPECT_EQ(upOf(y), "y") << y;
}

TEST(UpAxis, CommentInTheFileOverridesTheShape) {
  Cage cage = moved(pawn(), toZ);
  cage.comments = " y up\n";
  EXPECT_EQ(guessUp(cage).axis, "y");
  cage = pawn();
  cage.comments = " z up\n";
  EXPECT_EQ(guessUp(cage).axis, "z");
}

/* --- hints ------------------------------------------------------------------------------------ */

TEST(UpAxis, HintsConvertInBothDirections) {
  const Vec3f ups[] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {-1, 0, 0}};
  ASSERT_EQ(upAxes().size(), std::size(ups));
  const ViewHints hints;
  for (size_t i = 0; i < std::size(ups); i++) {
    const ViewHints turned = rotatedFromY(hints, upAxes()[i]), back = rotatedToY(turned, upAxes()[i]);
    EXPECT_EQ(length(turned.up - ups[i]), 0.0f) << upAxes()[i];
    EXPECT_FLOAT_EQ(dot(turned.direction, turned.up), dot(hints.direction, hints.up)) << upAxes()[i];
    EXPECT_EQ(length(back.up - hints.up), 0.0f) << upAxes()[i];
    EXPECT_EQ(length(back.direction - hints.direction), 0.0f) << upAxes()[i];
  }
}

}} // namespace programs::test
