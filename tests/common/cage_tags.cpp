// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Effects of the `t` tags of an OBJ on the traced surface, in stock GRID and in a compressed representation. */

#include "building/built_scene.h"
#include "surface/obj_reader.h"
#include "tracing/trace_hits.h"

#include <gtest/gtest.h>

#include <sstream>

namespace programs::test { namespace {

/* A cube of 2 x 2 x 2 around the origin with outward faces; face 0 is at -x, face 5 at +z. */
const std::string cube = "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n"
                         "f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n";

class CageTags : public testing::TestWithParam<RepresentationKind> {
protected:
  BuiltScene build(const std::string& tags) {
    std::istringstream stream(cube + tags);
    model.name = "cube";
    std::string warnings;
    model.cage = readObj(stream, "cube.obj", warnings);
    BuildSettings settings;
    settings.level = 5;
    settings.threads = 1;
    return BuiltScene(model, {GetParam(), 1}, settings);
  }

  /* Distance of the surface from the center in a direction: negative if only the far side is hit, infinite for a miss.
   */
  static float reach(const BuiltScene& scene, Vec3f direction) {
    const Ray ray{10.0f * normalize(direction), 0.0f, -normalize(direction), INFINITY};
    const SurfaceHit hit = traceClosest(scene, {ray}, 1)[0];
    return hit.hit() ? 10.0f - hit.t : INFINITY;
  }

  Model model;
};

constexpr float tolerance = 0.01f; // for a compressed surface at this level

TEST_P(CageTags, WithoutTagsTheCubeIsRound) {
  const BuiltScene scene = build("");
  EXPECT_LT(reach(scene, {1, 1, 1}), 1.0f);
  EXPECT_LT(reach(scene, {0, 0, 1}), 0.9f);
}

TEST_P(CageTags, HardCreasesKeepEdgesStraightAndFacesFlat) {
  const BuiltScene scene = build("t crease 24/1/0 0 1 1 3 3 2 2 0 4 5 5 7 7 6 6 4 0 4 1 5 2 6 3 7 10\n");
  EXPECT_NEAR(reach(scene, {0, 0, 1}), 1.0f, tolerance);
  EXPECT_NEAR(reach(scene, {0.9f, -0.5f, 1}), std::sqrt(0.81f + 0.25f + 1.0f), tolerance);
}

TEST_P(CageTags, SemiSharpCreasesLieBetween) {
  const float smooth = reach(build(""), {0, 1, 1});
  const float semi = reach(build("t crease 2/1/0 6 7 1.5\n"), {0, 1, 1});
  const float hard = reach(build("t crease 2/1/0 6 7 10\n"), {0, 1, 1});
  EXPECT_LT(smooth + 0.02f, semi);
  EXPECT_LT(semi + 0.02f, hard);
}

TEST_P(CageTags, HardCornersAreReached) {
  const BuiltScene scene = build("t corner 1/1/0 7 10\n");
  // leaves extend beyond the corner by less than a quad, and the bounds contain them
  const float past = GetParam() == RepresentationKind::Grid ? tolerance : 2.0f / 32;
  for (float upper : {scene.bounds().upper.x, scene.bounds().upper.y, scene.bounds().upper.z}) {
    EXPECT_GE(upper, 1.0f - tolerance);
    EXPECT_LE(upper, 1.0f + past);
  }
  EXPECT_GT(scene.bounds().lower.x, -0.9f) << "the other corners stay round";
}

TEST_P(CageTags, HolesHaveNoSurface) {
  const BuiltScene scene = build("t hole 1/0/0 5\n");
  EXPECT_EQ(scene.report().quads, 5u * 32 * 32);
  EXPECT_LT(reach(scene, {0, 0, 1}), 0.0f) << "the ray passes the hole and hits the far side";
  EXPECT_GT(reach(scene, {0, 0, -1}), 0.0f);
}

std::string kindName(const testing::TestParamInfo<RepresentationKind>& info) {
  return Representation{info.param}.fileStem();
}

INSTANTIATE_TEST_SUITE_P(Kinds, CageTags, testing::Values(RepresentationKind::Grid, RepresentationKind::CLeaf),
                         kindName);

}} // namespace programs::test
