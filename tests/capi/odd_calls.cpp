// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Incorrect callers of libembree_cbvh: NULL for every pointer, indices out of range, numbers that are not finite,
 * inconsistent cages, callbacks that change their object, misspelled settings. */

#include "small_cube.h"
#include "support/message_parts.h"
#include "support/saved.h"

#include <cbvh/cbvh.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits.h>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace programs::test { namespace {

struct OddCalls : ::testing::Test {
  CbvhContext context = nullptr;
  CbvhSurface surface = nullptr;
  CbvhGroup group = nullptr;

  OddCalls() {
    EXPECT_EQ(cbvhNewContext(nullptr, nullptr, nullptr, &context), CBVH_OK);
    EXPECT_EQ(cbvhNewSurface(context, &surface), CBVH_OK);
    const CbvhCage cage = cube();
    EXPECT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK) << cbvhGetErrorText();
  }
  ~OddCalls() override {
    cbvhReleaseGroup(group);
    cbvhReleaseSurface(surface);
    cbvhReleaseContext(context);
  }

  void commit() {
    ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
    ASSERT_EQ(cbvhNewGroup(context, &surface, 1, &group), CBVH_OK);
    ASSERT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();
  }

  bool isSeen(CbvhGroup by) const {
    CbvhRayHit r = rayFromAbove();
    return cbvhIntersect1(by, &r, nullptr) != 0;
  }
};

TEST_F(OddCalls, NullIsRejectedByEveryFunction) {
  commit();
  CbvhDicingArguments dicing = CbvhDicingArguments();
  CbvhGroupStatistics statistics;
  CbvhTriangle triangle;
  CbvhSurface noSurface = nullptr;
  CbvhGroup noGroup = nullptr;
  const CbvhCage cage = cube();
  const CbvhGrids grids = CbvhGrids();
  const CbvhMesh mesh = CbvhMesh();
  CbvhRayHit r = rayFromAbove();
  alignas(64) float packet[16 * 20] = {};
  size_t index = 0;
  unsigned primID = 0;
  float P[3] = {}, lower[3], upper[3];
  const CbvhPointQuery point = CbvhPointQuery();
  CbvhClosestPoint closest;
  const auto part = [](void*, const CbvhPart*) { return 1; };
  const Folder folder;
  CbvhFileWriter writer = nullptr, noWriter = nullptr;
  CbvhFile file = nullptr, noFile = nullptr;
  CbvhFileSurfaceInfo info;
  CbvhSurfaceStatistics ofSurface;
  ASSERT_EQ(cbvhSaveSurface(surface, (folder / "one").c_str()), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhNewFileWriter(context, (folder / "two").c_str(), &writer), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhOpenFile(context, (folder / "one").c_str(), &file), CBVH_OK) << cbvhGetErrorText();
  const std::vector<std::pair<const char*, std::function<CbvhError()>>> refused = {
      {"cbvhNewContext", [&] { return cbvhNewContext(nullptr, nullptr, nullptr, nullptr); }},
      {"cbvhNewSurface", [&] { return cbvhNewSurface(nullptr, &noSurface); }},
      {"cbvhNewSurface", [&] { return cbvhNewSurface(context, nullptr); }},
      {"cbvhSetSurfaceCage", [&] { return cbvhSetSurfaceCage(nullptr, &cage); }},
      {"cbvhSetSurfaceCage", [&] { return cbvhSetSurfaceCage(surface, nullptr); }},
      {"cbvhSetSurfaceGrids", [&] { return cbvhSetSurfaceGrids(nullptr, &grids); }},
      {"cbvhSetSurfaceGrids", [&] { return cbvhSetSurfaceGrids(surface, nullptr); }},
      {"cbvhSetSurfaceGrids", [&] { return cbvhSetSurfaceGrids(surface, &grids); }},
      {"cbvhSetSurfaceMesh", [&] { return cbvhSetSurfaceMesh(nullptr, &mesh); }},
      {"cbvhSetSurfaceMesh", [&] { return cbvhSetSurfaceMesh(surface, nullptr); }},
      {"cbvhSetSurfaceMesh", [&] { return cbvhSetSurfaceMesh(surface, &mesh); }},
      {"cbvhDiceSurface", [&] { return cbvhDiceSurface(nullptr, &dicing, nullptr); }},
      {"cbvhDiceSurface", [&] { return cbvhDiceSurface(surface, nullptr, nullptr); }},
      {"cbvhSetSurfaceAccuracy", [&] { return cbvhSetSurfaceAccuracy(nullptr, nullptr); }},
      {"cbvhSetSurfaceLossless", [&] { return cbvhSetSurfaceLossless(nullptr, 1); }},
      {"cbvhSetSurfaceMask", [&] { return cbvhSetSurfaceMask(nullptr, 1); }},
      {"cbvhCommitSurface", [&] { return cbvhCommitSurface(nullptr, nullptr, nullptr); }},
      {"cbvhInterpolateAttribute", [&] { return cbvhInterpolateAttribute(nullptr, 0, 0, 0, 0, P, nullptr, nullptr); }},
      {"cbvhInterpolateAttribute", [&] { return cbvhInterpolateAttribute(surface, 6, 0, 0, 0, P, nullptr, nullptr); }},
      {"cbvhInterpolateAttribute", [&] { return cbvhInterpolateAttribute(surface, 0, 0, 0, 1, P, nullptr, nullptr); }},
      {"cbvhInterpolateAttributeAtPoints",
       [&] {
         const CbvhInterpolationPoints none = CbvhInterpolationPoints();
         return cbvhInterpolateAttributeAtPoints(nullptr, &none);
       }},
      {"cbvhInterpolateAttributeAtPoints", [&] { return cbvhInterpolateAttributeAtPoints(surface, nullptr); }},
      {"cbvhInterpolateAttributeAtPoints",
       [&] {
         const CbvhInterpolationPoints null = {
             sizeof(CbvhInterpolationPoints), 0, 0, 1, nullptr, P, P, nullptr, nullptr};
         return cbvhInterpolateAttributeAtPoints(surface, &null);
       }},
      {"cbvhSaveSurface", [&] { return cbvhSaveSurface(nullptr, "/dev/null/none"); }},
      {"cbvhSaveSurface", [&] { return cbvhSaveSurface(surface, nullptr); }},
      {"cbvhLoadSurface", [&] { return cbvhLoadSurface(nullptr, "none", &noSurface); }},
      {"cbvhLoadSurface", [&] { return cbvhLoadSurface(context, nullptr, &noSurface); }},
      {"cbvhLoadSurface", [&] { return cbvhLoadSurface(context, "none", nullptr); }},
      {"cbvhNewFileWriter", [&] { return cbvhNewFileWriter(nullptr, "none", &noWriter); }},
      {"cbvhNewFileWriter", [&] { return cbvhNewFileWriter(context, nullptr, &noWriter); }},
      {"cbvhNewFileWriter", [&] { return cbvhNewFileWriter(context, "none", nullptr); }},
      {"cbvhResumeFileWriter", [&] { return cbvhResumeFileWriter(nullptr, "none", 1, &noWriter); }},
      {"cbvhResumeFileWriter", [&] { return cbvhResumeFileWriter(context, nullptr, 1, &noWriter); }},
      {"cbvhResumeFileWriter", [&] { return cbvhResumeFileWriter(context, "none", 1, nullptr); }},
      {"cbvhAppendSurface", [&] { return cbvhAppendSurface(nullptr, surface); }},
      {"cbvhAppendSurface", [&] { return cbvhAppendSurface(writer, nullptr); }},
      {"cbvhCommitFileWriter", [&] { return cbvhCommitFileWriter(nullptr); }},
      {"cbvhOpenFile", [&] { return cbvhOpenFile(nullptr, "none", &noFile); }},
      {"cbvhOpenFile", [&] { return cbvhOpenFile(context, nullptr, &noFile); }},
      {"cbvhOpenFile", [&] { return cbvhOpenFile(context, "none", nullptr); }},
      {"cbvhGetFileSurfaceInfo", [&] { return cbvhGetFileSurfaceInfo(nullptr, 0, &info); }},
      {"cbvhGetFileSurfaceInfo", [&] { return cbvhGetFileSurfaceInfo(file, 0, nullptr); }},
      {"cbvhGetFileSurfaceInfo", [&] { return cbvhGetFileSurfaceInfo(file, 1, &info); }},
      {"cbvhGetFileSurfaceStatistics", [&] { return cbvhGetFileSurfaceStatistics(nullptr, 0, &ofSurface); }},
      {"cbvhGetFileSurfaceStatistics", [&] { return cbvhGetFileSurfaceStatistics(file, 0, nullptr); }},
      {"cbvhGetFileSurfaceStatistics", [&] { return cbvhGetFileSurfaceStatistics(file, ~size_t(0), &ofSurface); }},
      {"cbvhLoadFileSurface", [&] { return cbvhLoadFileSurface(nullptr, 0, &noSurface); }},
      {"cbvhLoadFileSurface", [&] { return cbvhLoadFileSurface(file, 0, nullptr); }},
      {"cbvhLoadFileSurface", [&] { return cbvhLoadFileSurface(file, 1, &noSurface); }},
      {"cbvhVerifyFile", [&] { return cbvhVerifyFile(nullptr); }},
      {"cbvhNewGroup", [&] { return cbvhNewGroup(nullptr, &surface, 1, &noGroup); }},
      {"cbvhNewGroup", [&] { return cbvhNewGroup(context, nullptr, 1, &noGroup); }},
      {"cbvhNewGroup", [&] { return cbvhNewGroup(context, &surface, 0, &noGroup); }},
      {"cbvhNewGroup", [&] { return cbvhNewGroup(context, &surface, 1, nullptr); }},
      {"cbvhCommitGroup", [&] { return cbvhCommitGroup(nullptr); }},
      {"cbvhCheckGeometry", [&] { return cbvhCheckGeometry(nullptr, 0, 3); }},
      {"cbvhCheckGeometry", [&] { return cbvhCheckGeometry(group, 4, 3); }},
      {"cbvhGetGroupStatistics", [&] { return cbvhGetGroupStatistics(nullptr, &statistics); }},
      {"cbvhGetGroupStatistics", [&] { return cbvhGetGroupStatistics(group, nullptr); }},
      {"cbvhForEachPart", [&] { return cbvhForEachPart(nullptr, 0, part, nullptr); }},
      {"cbvhForEachPart", [&] { return cbvhForEachPart(surface, 0, nullptr, nullptr); }},
      {"cbvhForEachCluster",
       [&] { return cbvhForEachCluster(nullptr, 0, CBVH_CLUSTER_FORMAT_FLOAT3, nullptr, nullptr, nullptr); }},
      {"cbvhForEachCluster",
       [&] { return cbvhForEachCluster(surface, 0, CbvhClusterFormat(3), nullptr, nullptr, nullptr); }},
  };
  for (const auto& call : refused) {
    EXPECT_EQ(call.second(), CBVH_ERROR_INVALID_ARGUMENT) << call.first;
    EXPECT_STRNE(cbvhGetErrorText(), "") << call.first;
  }
  const std::vector<std::pair<const char*, std::function<size_t()>>> nothing = {
      {"cbvhGetSurfacePrimitiveCount", [&] { return cbvhGetSurfacePrimitiveCount(nullptr); }},
      {"cbvhGetFileWriterSurfaceCount", [&] { return cbvhGetFileWriterSurfaceCount(nullptr); }},
      {"cbvhGetFileSurfaceCount", [&] { return cbvhGetFileSurfaceCount(nullptr); }},
      {"cbvhGetGroupSurfaceCount", [&] { return cbvhGetGroupSurfaceCount(nullptr); }},
      {"cbvhGetGroupSurface", [&] { return size_t(cbvhGetGroupSurface(nullptr, 0)); }},
      {"cbvhGetGroupSurface", [&] { return size_t(cbvhGetGroupSurface(group, 1)); }},
      {"cbvhGetGroupSurface", [&] { return size_t(cbvhGetGroupSurface(group, ~size_t(0))); }},
      {"cbvhGetGroupUserPtr", [&] { return size_t(cbvhGetGroupUserPtr(nullptr)); }},
      {"cbvhGetGroupFirstPrimitive", [&] { return cbvhGetGroupFirstPrimitive(nullptr, 0); }},
      {"cbvhGetGroupFirstPrimitive", [&] { return cbvhGetGroupFirstPrimitive(group, 2); }},
      {"cbvhGetGroupFirstPrimitive", [&] { return cbvhGetGroupFirstPrimitive(group, ~size_t(0)); }},
      {"cbvhFindGroupPrimitive", [&] { return cbvhFindGroupPrimitive(nullptr, 0, &index, &primID); }},
      {"cbvhFindGroupPrimitive", [&] { return cbvhFindGroupPrimitive(group, 0, nullptr, &primID); }},
      {"cbvhFindGroupPrimitive", [&] { return cbvhFindGroupPrimitive(group, 0, &index, nullptr); }},
      {"cbvhFindGroupPrimitive", [&] { return cbvhFindGroupPrimitive(group, 6, &index, &primID); }},
      {"cbvhFindGroupPrimitive", [&] { return cbvhFindGroupPrimitive(group, ~0u, &index, &primID); }},
      {"cbvhPointQuery", [&] { return cbvhPointQuery(nullptr, &point, nullptr); }},
      {"cbvhPointQuery", [&] { return cbvhPointQuery(group, nullptr, nullptr); }},
      {"cbvhFindClosestPoint", [&] { return cbvhFindClosestPoint(nullptr, 0, 0, P, 1, &closest); }},
      {"cbvhFindClosestPoint", [&] { return cbvhFindClosestPoint(surface, 0, 0, nullptr, 1, &closest); }},
      {"cbvhFindClosestPoint", [&] { return cbvhFindClosestPoint(surface, 0, 0, P, 1, nullptr); }},
      {"cbvhFindClosestPoint", [&] { return cbvhFindClosestPoint(surface, 0, 6, P, INFINITY, &closest); }},
      {"cbvhIntersect1", [&] { return cbvhIntersect1(nullptr, &r, nullptr); }},
      {"cbvhIntersect1", [&] { return cbvhIntersect1(group, nullptr, nullptr); }},
      {"cbvhOccluded1", [&] { return cbvhOccluded1(nullptr, &r.ray, nullptr); }},
      {"cbvhOccluded1", [&] { return cbvhOccluded1(group, nullptr, nullptr); }},
      {"cbvhIntersect4",
       [&] {
         return cbvhIntersect4(nullptr, nullptr, packet, nullptr) + cbvhIntersect4(group, nullptr, nullptr, nullptr);
       }},
      {"cbvhIntersect8",
       [&] {
         return cbvhIntersect8(nullptr, nullptr, packet, nullptr) + cbvhIntersect8(group, nullptr, nullptr, nullptr);
       }},
      {"cbvhIntersect16",
       [&] {
         return cbvhIntersect16(nullptr, nullptr, packet, nullptr) + cbvhIntersect16(group, nullptr, nullptr, nullptr);
       }},
      {"cbvhOccluded4",
       [&] {
         return cbvhOccluded4(nullptr, nullptr, packet, nullptr) + cbvhOccluded4(group, nullptr, nullptr, nullptr);
       }},
      {"cbvhOccluded8",
       [&] {
         return cbvhOccluded8(nullptr, nullptr, packet, nullptr) + cbvhOccluded8(group, nullptr, nullptr, nullptr);
       }},
      {"cbvhOccluded16",
       [&] {
         return cbvhOccluded16(nullptr, nullptr, packet, nullptr) + cbvhOccluded16(group, nullptr, nullptr, nullptr);
       }},
      {"cbvhFindTriangle", [&] { return cbvhFindTriangle(nullptr, 0, 0, 0, 0, nullptr, &triangle); }},
      {"cbvhFindTriangle", [&] { return cbvhFindTriangle(surface, 0, 0, 0, 0, nullptr, nullptr); }},
  };
  for (const auto& call : nothing) EXPECT_EQ(call.second(), 0u) << call.first;
  cbvhRetainContext(nullptr);
  cbvhReleaseContext(nullptr);
  cbvhRetainSurface(nullptr);
  cbvhReleaseSurface(nullptr);
  cbvhRetainGroup(nullptr);
  cbvhReleaseGroup(nullptr);
  cbvhReleaseFileWriter(nullptr);
  cbvhReleaseFile(nullptr);
  cbvhReleaseFileWriter(writer);
  cbvhReleaseFile(file);
  cbvhSetGroupUserPtr(nullptr, nullptr);
  cbvhIntersectGeometry(nullptr);
  cbvhOccludedGeometry(nullptr);
  const int valid = -1;
  CbvhGeometryQuery query = CbvhGeometryQuery();
  query.valid = &valid;
  query.rays = &r;
  query.N = 1;
  cbvhIntersectGeometry(&query); // without a group
  cbvhOccludedGeometry(&query);
  query.group = group;
  query.numLevels = 33;
  cbvhIntersectGeometry(&query);
  cbvhOccludedGeometry(&query);
  EXPECT_EQ(r.ray.tfar, rayFromAbove().ray.tfar);
  cbvhGetGroupBounds(group, nullptr, upper);
  cbvhGetGroupBounds(group, lower, nullptr);
  EXPECT_LT(lower[0], upper[0]);
  cbvhGetGroupBounds(nullptr, lower, upper);
  EXPECT_GT(lower[0], upper[0]);
  EXPECT_TRUE(isSeen(group)) << "nothing was changed";
}

TEST_F(OddCalls, InconsistentCagesAreRejectedWhenSet) {
  const unsigned few[] = {4, 4, 4, 4, 4, 3}, many[] = {4, 4, 4, 4, 4, 400}, flat[] = {4, 4, 4, 4, 6, 2};
  std::vector<unsigned> past(cubeIndices, cubeIndices + 24);
  past[13] = 8;
  const unsigned crease[] = {0, 9}, seven[] = {7};
  const float sharp[] = {INFINITY};
  const auto expectInvalid = [&](const std::vector<std::string>& parts, const std::function<void(CbvhCage&)>& modify) {
    CbvhCage cage = cube();
    modify(cage);
    EXPECT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_ERROR_INVALID_ARGUMENT) << testing::PrintToString(parts);
    EXPECT_TRUE(containsInOrder(cbvhGetErrorText(), parts));
  };
  expectInvalid({"faces", " 23 ", " 24 ", "indices"}, [&](CbvhCage& c) { c.faceVertexCounts = few; });
  expectInvalid({"face 5 ", " 420", " 24 ", "indices"}, [&](CbvhCage& c) { c.faceVertexCounts = many; });
  expectInvalid({"face 5 ", " 2 ", "vertices", "3"}, [&](CbvhCage& c) { c.faceVertexCounts = flat; });
  expectInvalid({"index 13 ", "vertex 8", " 8 "}, [&](CbvhCage& c) { c.indices = past.data(); });
  expectInvalid({"crease index 1 ", "vertex 9", " 8 "}, [&](CbvhCage& c) {
    c.numCreases = 1;
    c.creases = crease;
    c.creaseSharpness = sharp;
  });
  expectInvalid({"corner 0 ", "vertex 9", " 8 "}, [&](CbvhCage& c) {
    c.numCorners = 1;
    c.corners = crease + 1;
    c.cornerSharpness = sharp;
  });
  expectInvalid({"hole 0 ", "face 7", " 6 "}, [&](CbvhCage& c) {
    c.numHoles = 1;
    c.holes = seven;
  });
  CbvhDicingArguments dicing = CbvhDicingArguments();
  dicing.position[2] = 5;
  dicing.pixelSize = 0.1f;
  EXPECT_EQ(cbvhDiceSurface(surface, &dicing, nullptr), CBVH_OK) << "the previous cage is still set";
  commit();
  EXPECT_TRUE(isSeen(group));
}

const float oddNumbers[] = {-1,     -0.01f,   1.5f,      8,   1e7f,    -1e7f,   1e30f,
                            -1e30f, INFINITY, -INFINITY, NAN, FLT_MAX, -FLT_MAX};

TEST_F(OddCalls, OddParametersAreRejected) {
  commit();
  CbvhTriangle triangle;
  float uv[2], du[2], dv[2];
  for (float odd : oddNumbers)
    for (const auto& at : {std::make_pair(odd, 0.5f), std::make_pair(0.5f, odd), std::make_pair(odd, odd)}) {
      EXPECT_EQ(cbvhInterpolateAttribute(surface, 0, at.first, at.second, 0, uv, du, dv), CBVH_ERROR_INVALID_ARGUMENT)
          << at.first << " " << at.second;
      EXPECT_EQ(cbvhFindTriangle(surface, 0, 0, at.first, at.second, nullptr, &triangle), 0)
          << at.first << " " << at.second;
    }
  const auto part = [](void*, const CbvhPart*) { return 1; };
  for (float odd : {INFINITY, -INFINITY, float(NAN)}) {
    // surfaces that do not move ignore the time
    EXPECT_EQ(cbvhFindTriangle(surface, odd, 0, 0.5f, 0.5f, nullptr, &triangle), 1);
    EXPECT_EQ(cbvhForEachPart(surface, odd, part, nullptr), CBVH_OK) << cbvhGetErrorText();
    EXPECT_EQ(cbvhForEachCluster(surface, odd, CBVH_CLUSTER_FORMAT_FLOAT3, nullptr, nullptr, nullptr), CBVH_OK);
  }
  EXPECT_EQ(cbvhInterpolateAttribute(surface, 0, 1, 0, 0, uv, du, dv), CBVH_OK);
  EXPECT_EQ(cbvhFindTriangle(surface, 0, 0, 1, 0, nullptr, &triangle), 1);
}

// A face of 5 corners has the sub-patches 0 to 4.
TEST_F(OddCalls, MissingSubPatchesAreRejected) {
  const unsigned faces[] = {5}, indices[] = {0, 1, 2, 3, 4};
  CbvhCage cage = cube();
  cage.numFaces = 1;
  cage.faceVertexCounts = faces;
  cage.numIndices = 5;
  cage.indices = indices;
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK);
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  float uv[2];
  for (unsigned i = 0; i < 16; i++) {
    const float u = 1 + 2.0f * (i % 4), v = 1 + 2.0f * (i / 4);
    uv[0] = uv[1] = NAN;
    const CbvhError found = cbvhInterpolateAttribute(surface, 0, u, v, 0, uv, nullptr, nullptr);
    EXPECT_EQ(found, i < 5 ? CBVH_OK : CBVH_ERROR_INVALID_ARGUMENT) << i;
    EXPECT_EQ(std::isfinite(uv[0]) && std::isfinite(uv[1]), i < 5) << i;
  }
  for (float odd : oddNumbers)
    if (!(odd >= 0 && odd < 8)) {
      EXPECT_EQ(cbvhInterpolateAttribute(surface, 0, odd, 1, 0, uv, nullptr, nullptr), CBVH_ERROR_INVALID_ARGUMENT)
          << odd;
    }
}

struct Attempts {
  CbvhSurface surface;
  std::atomic<unsigned> calls{0}, refused{0}, interpolated{0};

  void make() {
    const CbvhCage cage = cube();
    const CbvhError errors[] = {cbvhSetSurfaceCage(surface, &cage), cbvhCommitSurface(surface, nullptr, nullptr),
                                cbvhSetSurfaceAccuracy(surface, nullptr), cbvhSetSurfaceMask(surface, 3)};
    calls++;
    for (CbvhError error : errors) refused += error == CBVH_ERROR_INVALID_OPERATION;
  }
};

TEST_F(OddCalls, CallbacksMustNotChangeTheirSurface) {
  Attempts attempts{surface};
  CbvhCage cage = cube();
  cage.displacementUserPtr = &attempts;
  cage.displacement = [](const CbvhDisplacementArguments* args) {
    Attempts& attempts = *(Attempts*)args->userPtr;
    attempts.make();
    float uv[2] = {-9, -9};
    if (cbvhInterpolateAttribute(attempts.surface, args->primID, args->u[0], args->v[0], 0, uv, nullptr, nullptr) ==
            CBVH_OK &&
        uv[0] >= 0 && uv[0] <= 1)
      attempts.interpolated++;
  };
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK);
  CbvhDicingArguments dicing = CbvhDicingArguments();
  dicing.position[2] = 5;
  dicing.pixelSize = 0.1f;
  ASSERT_EQ(cbvhDiceSurface(surface, &dicing, nullptr), CBVH_OK) << cbvhGetErrorText();
  const unsigned diced = attempts.calls;
  EXPECT_GT(diced, 0u);
  ASSERT_EQ(cbvhCommitSurface(
                surface,
                [](void* self, double) {
                  ((Attempts*)self)->make();
                  return 1;
                },
                &attempts),
            CBVH_OK)
      << cbvhGetErrorText();
  EXPECT_GT(attempts.calls, diced);
  EXPECT_EQ(attempts.refused, 4 * attempts.calls);
  EXPECT_GT(attempts.interpolated, 6u) << "attributes are available during displacement";
  EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << "changes are possible again";
}

// The first commit releases the input. Values that select the same blocks are no change of the accuracy: repeated ones,
// a camera without a bound in pixels, the sign of 0, and any accuracy of a lossless surface, which ignores it.
TEST_F(OddCalls, AccuracyThatSelectsTheSameBlocksIsNoChange) {
  const CbvhCage cage = cube();
  for (int lossless : {0, 1}) {
    SCOPED_TRACE(lossless);
    ASSERT_EQ(cbvhSetSurfaceLossless(surface, lossless), CBVH_OK);
    ASSERT_EQ(cbvhSetSurfaceAccuracy(surface, nullptr), CBVH_OK);
    ASSERT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK);
    ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
    CbvhAccuracy accuracy = CbvhAccuracy();
    const auto commit = [&] {
      EXPECT_EQ(cbvhSetSurfaceLossless(surface, lossless), CBVH_OK);
      EXPECT_EQ(cbvhSetSurfaceAccuracy(surface, &accuracy), CBVH_OK) << cbvhGetErrorText();
      return cbvhCommitSurface(surface, nullptr, nullptr);
    };
    EXPECT_EQ(commit(), CBVH_OK) << cbvhGetErrorText();
    accuracy.maxError = -0.0f;
    accuracy.cameraPosition[1] = 3;
    EXPECT_EQ(commit(), CBVH_OK) << cbvhGetErrorText();
    accuracy.maxError = 0.25f;
    EXPECT_EQ(commit(), lossless ? CBVH_OK : CBVH_ERROR_INVALID_OPERATION) << cbvhGetErrorText();
    accuracy.maxError = 0;
    accuracy.maxPixelError = accuracy.pixelSize = 0.5f;
    EXPECT_EQ(commit(), lossless ? CBVH_OK : CBVH_ERROR_INVALID_OPERATION) << cbvhGetErrorText();
    accuracy = CbvhAccuracy();
    EXPECT_EQ(commit(), CBVH_OK) << "the accuracy of the commit again: " << cbvhGetErrorText();
  }
  ASSERT_EQ(cbvhSetSurfaceLossless(surface, 0), CBVH_OK);
  EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_ERROR_INVALID_OPERATION);
}

// The attribute equals u and v, so the interpolated values must equal the arguments of the displacement.
TEST_F(OddCalls, TextureCoordinatesAreAvailableDuringDisplacement) {
  const unsigned own[] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
  const CbvhAttribute unit = {corners, 4, 8, 2, own, CBVH_BOUNDARY_PIN_ALL}; // equal to u and v
  struct State {
    CbvhSurface surface;
    std::atomic<size_t> points{0}, wrong{0};
  } state{surface};
  CbvhCage cage = cube();
  cage.attributes = &unit;
  cage.displacementUserPtr = &state;
  cage.displacement = [](const CbvhDisplacementArguments* args) {
    State& state = *(State*)args->userPtr;
    std::vector<float> uv(2 * args->count, -9), du(uv), dv(uv);
    const CbvhInterpolationPoints points = {sizeof(CbvhInterpolationPoints),
                                            args->primID,
                                            0,
                                            args->count,
                                            args->u,
                                            args->v,
                                            uv.data(),
                                            du.data(),
                                            dv.data()};
    if (cbvhInterpolateAttributeAtPoints(state.surface, &points) != CBVH_OK) {
      state.wrong += args->count;
      return;
    }
    for (unsigned i = 0; i < args->count; i++) {
      state.points++;
      state.wrong += !(std::fabs(uv[2 * i] - args->u[i]) < 1e-4f && std::fabs(uv[2 * i + 1] - args->v[i]) < 1e-4f &&
                       std::fabs(du[2 * i] - 1) < 1e-3f && std::fabs(dv[2 * i + 1] - 1) < 1e-3f);
    }
  };
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK) << cbvhGetErrorText();
  float P[2];
  EXPECT_EQ(cbvhInterpolateAttribute(surface, 0, 0.5f, 0.5f, 0, P, nullptr, nullptr), CBVH_ERROR_INVALID_OPERATION)
      << "not committed";
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  EXPECT_GE(state.points, 6u * 9 * 9);
  EXPECT_EQ(state.wrong, 0u);
  const float u[] = {0.5f, NAN}, v[] = {0.5f, 0.5f};
  P[0] = -9;
  const CbvhInterpolationPoints points = {sizeof(CbvhInterpolationPoints), 0, 0, 2, u, v, P, nullptr, nullptr};
  EXPECT_EQ(cbvhInterpolateAttributeAtPoints(surface, &points), CBVH_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(P[0], -9) << "nothing is written";
}

TEST_F(OddCalls, PartCallbackMayReleaseTheLastReference) {
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK);
  const auto release = [](void* self, const CbvhPart* part) {
    CbvhSurface& surface = *(CbvhSurface*)self;
    cbvhReleaseSurface(surface);
    surface = nullptr;
    return int(part->width == 0);
  };
  EXPECT_EQ(cbvhForEachPart(surface, 0, release, &surface), CBVH_OK);
  EXPECT_EQ(surface, nullptr);
}

// Afterwards the surface can be diced and committed.
TEST_F(OddCalls, FailedCommitsLeaveTheSurfaceUnchanged) {
  static std::atomic<bool> throws;
  CbvhCage cage = cube();
  cage.rate = 64;
  cage.displacement = [](const CbvhDisplacementArguments*) {
    if (throws) throw std::runtime_error("no such texture");
  };
  CbvhDicingArguments dicing = CbvhDicingArguments();
  dicing.position[2] = 5;
  dicing.pixelSize = 0.1f;
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK);
  for (int round = 0; round < 3; round++) {
    throws = round == 1;
    if (round == 0) {
      EXPECT_EQ(cbvhCommitSurface(surface, [](void*, double) { return 0; }, nullptr), CBVH_ERROR_CANCELLED);
    } else if (round == 1) {
      EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_ERROR_UNKNOWN);
      EXPECT_NE(std::string(cbvhGetErrorText()).find("no such texture"), std::string::npos) << cbvhGetErrorText();
    } else {
      throws = true;
      EXPECT_EQ(cbvhDiceSurface(surface, &dicing, nullptr), CBVH_ERROR_UNKNOWN);
    }
    throws = false;
    EXPECT_EQ(cbvhDiceSurface(surface, &dicing, nullptr), CBVH_OK) << round << cbvhGetErrorText();
  }
  commit();
  EXPECT_TRUE(isSeen(group));
}

TEST_F(OddCalls, MaskTakesEffectWithTheNextCommitOfAGroup) {
  commit();
  CbvhGroupStatistics before, after;
  ASSERT_EQ(cbvhGetGroupStatistics(group, &before), CBVH_OK);
  ASSERT_EQ(cbvhSetSurfaceMask(surface, 2), CBVH_OK);
  EXPECT_TRUE(isSeen(group));
  EXPECT_EQ(cbvhGetGroupStatistics(group, &after), CBVH_OK) << cbvhGetErrorText();
  EXPECT_EQ(before.bytes, after.bytes);
  ASSERT_EQ(cbvhCommitGroup(group), CBVH_OK);
  EXPECT_FALSE(isSeen(group));
  ASSERT_EQ(cbvhSetSurfaceMask(surface, 3), CBVH_OK);
  ASSERT_EQ(cbvhCommitGroup(group), CBVH_OK);
  EXPECT_TRUE(isSeen(group));
}

// A later version may define them: ignoring them would change what a program traces.
TEST_F(OddCalls, UnknownFlagsOfQueriesAreRejected) {
  commit();
  const CbvhRayHit ray = rayFromAbove();
  alignas(16) float packet[20 * 4];
  for (unsigned word = 0; word < 20; word++)
    for (unsigned i = 0; i < 4; i++) std::memcpy(&packet[4 * word + i], (const char*)&ray + 4 * word, 4);
  CbvhQuery query = CbvhQuery();
  for (unsigned flags : {2u, 0x80000001u}) {
    query.flags = flags;
    CbvhRayHit closest = ray;
    CbvhRay any = ray.ray;
    EXPECT_EQ(cbvhIntersect1(group, &closest, &query), 0);
    EXPECT_TRUE(containsInOrder(cbvhGetErrorText(), {flags == 2 ? "0x2 " : "0x80000000 ", "query", "0x1"}));
    EXPECT_EQ(cbvhOccluded1(group, &any, &query), 0);
    EXPECT_EQ(closest.ray.tfar, INFINITY);
    EXPECT_EQ(any.tfar, INFINITY);
    EXPECT_EQ(cbvhIntersect4(group, nullptr, packet, &query), 0u);
    EXPECT_EQ(cbvhOccluded4(group, nullptr, packet, &query), 0u);
  }
  query.flags = CBVH_QUERY_FLAG_COHERENT;
  EXPECT_EQ(cbvhIntersect4(group, nullptr, packet, &query), 15u);
}

TEST_F(OddCalls, StatisticsOfAnotherGroupStayAvailable) {
  commit();
  CbvhGroup other = nullptr;
  ASSERT_EQ(cbvhNewGroup(context, &surface, 1, &other), CBVH_OK);
  CbvhGroupStatistics statistics;
  EXPECT_EQ(cbvhGetGroupStatistics(other, &statistics), CBVH_ERROR_INVALID_OPERATION) << "not committed";
  ASSERT_EQ(cbvhCommitGroup(other), CBVH_OK);
  ASSERT_EQ(cbvhSetSurfaceMask(surface, 2), CBVH_OK);
  ASSERT_EQ(cbvhCommitGroup(other), CBVH_OK);
  EXPECT_EQ(cbvhGetGroupStatistics(group, &statistics), CBVH_OK) << cbvhGetErrorText();
  EXPECT_EQ(statistics.numQuads, 6u * 8 * 8);
  cbvhReleaseGroup(other);
}

// A displacement function commits a group with the surface that is being committed, whose mask has changed.
TEST_F(OddCalls, FailedCommitOfAGroupLeavesItUnchanged) {
  std::vector<float> distant(cubeVertices, cubeVertices + 25);
  for (size_t i = 0; i < 24; i += 3) distant[i] += 100;
  const float* const steps[] = {distant.data()};
  CbvhCage cage = cube();
  cage.vertices.steps = steps;
  CbvhSurface second = nullptr;
  ASSERT_EQ(cbvhNewSurface(context, &second), CBVH_OK);
  ASSERT_EQ(cbvhSetSurfaceCage(second, &cage), CBVH_OK) << cbvhGetErrorText();
  const CbvhSurface both[] = {surface, second};
  for (CbvhSurface one : both) ASSERT_EQ(cbvhCommitSurface(one, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhNewGroup(context, both, 2, &group), CBVH_OK);
  ASSERT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK);
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();

  struct State {
    CbvhGroup group;
    std::atomic<unsigned> calls{0};
    CbvhError error = CBVH_OK;
  } state{group};
  cage.displacementUserPtr = &state;
  cage.displacement = [](const CbvhDisplacementArguments* args) {
    State& state = *(State*)args->userPtr;
    if (state.calls++ == 0) state.error = cbvhCommitGroup(state.group);
  };
  ASSERT_EQ(cbvhSetSurfaceMask(second, 3), CBVH_OK);
  ASSERT_EQ(cbvhSetSurfaceCage(second, &cage), CBVH_OK);
  ASSERT_EQ(cbvhCommitSurface(second, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  EXPECT_GT(state.calls, 0u);
  EXPECT_EQ(state.error, CBVH_ERROR_INVALID_OPERATION);
  float lower[3], upper[3];
  cbvhGetGroupBounds(group, lower, upper);
  EXPECT_LT(lower[0], 0) << "the group still contains the surfaces of its last commit";
  EXPECT_TRUE(isSeen(group));
  EXPECT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();
  EXPECT_FALSE(isSeen(group));
  cbvhReleaseSurface(second);
}

TEST_F(OddCalls, FailedCommitOfAGroupAppliesNoMask) {
  commit();
  CbvhSurface empty = nullptr;
  ASSERT_EQ(cbvhNewSurface(context, &empty), CBVH_OK);
  const CbvhSurface both[] = {surface, empty};
  CbvhGroup other = nullptr;
  ASSERT_EQ(cbvhNewGroup(context, both, 2, &other), CBVH_OK);
  ASSERT_EQ(cbvhSetSurfaceMask(surface, 2), CBVH_OK);
  EXPECT_EQ(cbvhCommitGroup(other), CBVH_ERROR_INVALID_OPERATION);
  EXPECT_TRUE(isSeen(group));
  ASSERT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();
  EXPECT_FALSE(isSeen(group));
  cbvhReleaseGroup(other);
  cbvhReleaseSurface(empty);
}

TEST_F(OddCalls, AccuracyThatCannotBeAppliedRemainsAnError) {
  commit();
  const CbvhAccuracy fine = {sizeof(CbvhAccuracy), 0.001f, 0, {0, 0, 0}, 0};
  for (int i = 0; i < 2; i++) {
    ASSERT_EQ(cbvhSetSurfaceAccuracy(surface, &fine), CBVH_OK);
    EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_ERROR_INVALID_OPERATION);
  }
  ASSERT_EQ(cbvhSetSurfaceAccuracy(surface, nullptr), CBVH_OK);
  EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << "the stored accuracy";
}

TEST(OddContexts, ErrorFunctionMayCauseErrors) {
  struct Reported {
    CbvhContext context = nullptr;
    std::string before, after;
  } reported;
  const auto tell = [](void* self, CbvhError, const char* text) {
    Reported& reported = *(Reported*)self;
    if (!reported.before.empty()) return;
    reported.before = text;
    CbvhSurface none = nullptr;
    for (int i = 0; i < 100; i++)
      cbvhLoadSurface(reported.context, ("/no/such/file/with/a/long/name/" + std::to_string(i)).c_str(), &none);
    reported.after = text;
  };
  ASSERT_EQ(cbvhNewContext(nullptr, tell, &reported, &reported.context), CBVH_OK);
  CbvhSurface none = nullptr;
  EXPECT_EQ(cbvhLoadSurface(reported.context, "/no/such/folder/of/the/application/first.cbvh", &none),
            CBVH_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(reported.before.find("first.cbvh"), std::string::npos);
  EXPECT_EQ(reported.after, reported.before);
  EXPECT_EQ(cbvhGetErrorText(), reported.before);
  cbvhReleaseContext(reported.context);
}

TEST(OddContexts, InvalidSettingsNameTheKeyAndSuggestTheNearest) {
  const std::vector<std::string> wrong[] = {{"thread=2", "\"thread\"", "threads"},
                                            {"isa=avx9", "\"avx9\"", "isa", "avx2"},
                                            {"max_isa=bogus", "\"bogus\"", "max_isa"},
                                            {"threads=two", "\"two\"", "threads", "integer"},
                                            {"threads=4e", "\"4e\"", "threads", "integer"},
                                            {"threads=1-2", "\"1-2\"", "threads", "integer"},
                                            {"threads=1.5", "\"1.5\"", "threads", "integer"},
                                            {"verbose=4294967298", "\"4294967298\"", "verbose", "integer"},
                                            {"cache_size=big", "\"big\"", "cache_size", "number"},
                                            {"accel=3", "\"3\"", "accel", "name"},
                                            {"subdiv_accel=\"cbvh.vert\"", "\"\"cbvh.vert\"\"", "subdiv_accel", "name"},
                                            {"threads", "\"\"", "threads", "threads="},
                                            {"verbos=1,threads=2", "\"verbos\"", "verbose"},
                                            {"threads=2, cbvh_grid=1", "\"cbvh_grid\"", "cbvh_grids"},
                                            {"subdiv_acel=cbvh", "\"subdiv_acel\"", "subdiv_accel"},
                                            {"cbvh_max_error=-1", "\"-1\"", "cbvh_max_error", " 0 "},
                                            {"scene_flags=robust|fast", "\"robust|fast\"", "scene_flags", "dynamic"}};
  for (const auto& w : wrong) {
    CbvhContext context = nullptr;
    EXPECT_EQ(cbvhNewContext(w[0].c_str(), nullptr, nullptr, &context), CBVH_ERROR_INVALID_ARGUMENT) << w[0];
    EXPECT_EQ(context, nullptr) << w[0];
    EXPECT_TRUE(containsInOrder(cbvhGetErrorText(), w)); // quotes the settings, then names the wrong ones
  }
  for (const char* right : {"", "threads=2", "threads = 2 , verbose=0", "scene_flags = robust | compact, threads=1",
                            "tri_accel=default,cbvh_max_error=0.5", "tessellation_cache_size=0.5"}) {
    CbvhContext context = nullptr;
    EXPECT_EQ(cbvhNewContext(right, nullptr, nullptr, &context), CBVH_OK) << right << cbvhGetErrorText();
    cbvhReleaseContext(context);
  }
}

TEST(OddContexts, InstructionSetsThatTheCpuLacksAreTheReason) {
  CbvhContext context = nullptr;
  const CbvhError error = cbvhNewContext("isa=avx512", nullptr, nullptr, &context);
  cbvhReleaseContext(context);
  if (error == CBVH_OK) GTEST_SKIP() << "this CPU has AVX-512";
  EXPECT_EQ(error, CBVH_ERROR_UNSUPPORTED_CPU);
  EXPECT_TRUE(containsInOrder(cbvhGetErrorText(), {"isa=avx512", "CPU", "selected ISA"}));
}

TEST(OddContexts, ThereMayBeMoreThanKeysOfPthreads) {
  std::vector<CbvhContext> contexts(PTHREAD_KEYS_MAX + 100);
  for (CbvhContext& context : contexts)
    ASSERT_EQ(cbvhNewContext("threads=1", nullptr, nullptr, &context), CBVH_OK) << cbvhGetErrorText();
  for (CbvhContext context : contexts) cbvhReleaseContext(context);
}

// A prism with 20 sides: neither its caps nor the adjacent faces can be subdivided.
TEST_F(OddCalls, FacesWithTooManyCornersAreReportedOnce) {
  std::vector<float> vertices;
  std::vector<unsigned> faces = {20, 20}, indices;
  for (unsigned k = 0; k < 2; k++)
    for (unsigned i = 0; i < 20; i++) {
      const float a = 0.314159f * float(i);
      vertices.insert(vertices.end(), {std::cos(a), std::sin(a), float(k)});
      indices.push_back(20 * k + (k ? i : 19 - i));
    }
  for (unsigned i = 0; i < 20; i++) {
    faces.push_back(4);
    indices.insert(indices.end(), {i, (i + 1) % 20, 20 + (i + 1) % 20, 20 + i});
  }
  vertices.push_back(0);
  const float* const steps[] = {vertices.data()};
  CbvhCage cage = CbvhCage();
  cage.numFaces = faces.size();
  cage.faceVertexCounts = faces.data();
  cage.numIndices = indices.size();
  cage.indices = indices.data();
  cage.vertices = {40, 12, steps, 1, 0, 1};
  cage.rate = 4;
  CbvhSurface prism = nullptr;
  ASSERT_EQ(cbvhNewSurface(context, &prism), CBVH_OK);
  ASSERT_EQ(cbvhSetSurfaceCage(prism, &cage), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhCommitSurface(prism, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  const CbvhSurface both[] = {prism, surface};
  ASSERT_EQ(cbvhNewGroup(context, both, 2, &group), CBVH_OK);
  EXPECT_EQ(cbvhCommitGroup(group), CBVH_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(cbvhGetErrorText(), {"22 face", "16 ", "1024 "}));
  CbvhGroupStatistics statistics;
  EXPECT_EQ(cbvhGetGroupStatistics(group, &statistics), CBVH_OK) << "the other faces exist";
  EXPECT_EQ(statistics.numQuads, 6u * 64);
  EXPECT_EQ(cbvhSetSurfaceMask(prism, 1), CBVH_OK);
  EXPECT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhSetSurfaceCage(prism, &cage), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhCommitSurface(prism, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  EXPECT_EQ(cbvhCommitGroup(group), CBVH_ERROR_INVALID_ARGUMENT) << "a new cage leaves out as many faces";
  EXPECT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();
  cbvhReleaseSurface(prism);
}

}} // namespace programs::test
