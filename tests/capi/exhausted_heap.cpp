// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* libembree_cbvh while the heap is exhausted: rays still hit the last commit of a group whose commit fails, and no
 * exception leaves a function. */

#include "small_cube.h"
#include "support/exhaustible_heap.h"

#include <cbvh/cbvh.h>
#include <gtest/gtest.h>

#include <iterator>
#include <string>
#include <vector>

namespace programs::test { namespace {

TEST(CapiExhaustedHeap, GroupKeepsItsLastCommit) {
  std::vector<float> vertices(std::begin(cubeVertices), std::end(cubeVertices));
  const float* const steps[] = {vertices.data()};
  CbvhCage cage = cube();
  cage.vertices.steps = steps;
  CbvhContext context = nullptr;
  CbvhSurface surface = nullptr;
  CbvhGroup group = nullptr;
  ASSERT_EQ(cbvhNewContext(nullptr, nullptr, nullptr, &context), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhNewSurface(context, &surface), CBVH_OK);
  ASSERT_EQ(cbvhNewGroup(context, &surface, 1, &group), CBVH_OK);
  const auto commitSurface = [&] {
    EXPECT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK) << cbvhGetErrorText();
    EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  };
  const auto distance = [&] {
    CbvhRayHit ray = rayFromAbove();
    return cbvhIntersect1(group, &ray, nullptr) ? ray.ray.tfar : -1.0f;
  };
  commitSurface();
  ASSERT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();
  const float before = distance();
  EXPECT_GT(before, 0.0f);
  for (float& x : vertices) x *= 2; // the top of the larger cube is nearer
  commitSurface();
  isExhausted = true;
  const CbvhError error = cbvhCommitGroup(group);
  isExhausted = false;
  EXPECT_GT(refused, 0u) << "no allocation was refused, so nothing is tested";
  EXPECT_EQ(error, CBVH_ERROR_OUT_OF_MEMORY) << cbvhGetErrorText();
  EXPECT_EQ(distance(), before);
  EXPECT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();
  EXPECT_GT(distance(), 0.0f);
  EXPECT_LT(distance(), before);
  cbvhReleaseGroup(group);
  cbvhReleaseSurface(surface);
  cbvhReleaseContext(context);
}

TEST(CapiExhaustedHeap, GroupWithoutACommitNumbersNoPrimitives) {
  const CbvhCage cage = cube();
  CbvhContext context = nullptr;
  CbvhSurface surface = nullptr;
  ASSERT_EQ(cbvhNewContext("threads=1", nullptr, nullptr, &context), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhNewSurface(context, &surface), CBVH_OK);
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  CbvhError error = CBVH_ERROR_UNKNOWN;
  for (unsigned n = 0; error != CBVH_OK; n++) { // refuses all allocations after the first n
    SCOPED_TRACE(n);
    CbvhGroup group = nullptr;
    ASSERT_EQ(cbvhNewGroup(context, &surface, 1, &group), CBVH_OK) << cbvhGetErrorText();
    allowed = n;
    isExhausted = true;
    error = cbvhCommitGroup(group);
    isExhausted = false;
    allowed = 0;
    size_t index = 0;
    unsigned primID = 0;
    EXPECT_EQ(cbvhGetGroupFirstPrimitive(group, 1), error == CBVH_OK ? 6u : 0u);
    EXPECT_EQ(cbvhFindGroupPrimitive(group, 5, &index, &primID), error == CBVH_OK);
    cbvhReleaseGroup(group);
    ASSERT_LT(n, 10000u);
  }
  cbvhReleaseSurface(surface);
  cbvhReleaseContext(context);
}

TEST(CapiExhaustedHeap, ContextsReturnTheReason) {
  CbvhError error = CBVH_ERROR_UNKNOWN;
  refusesOnce = true;
  for (unsigned n = 0; error != CBVH_OK; n++) { // refuses one allocation after the first n
    SCOPED_TRACE(n);
    CbvhContext context = nullptr;
    allowed = n;
    isExhausted = true;
    error = cbvhNewContext("threads=1", nullptr, nullptr, &context);
    isExhausted = false;
    allowed = 0;
    ASSERT_EQ(context != nullptr, error == CBVH_OK);
    if (error != CBVH_OK) {
      EXPECT_EQ(error, CBVH_ERROR_OUT_OF_MEMORY);
      EXPECT_NE(std::string(cbvhGetErrorText()).find("out of memory"), std::string::npos) << cbvhGetErrorText();
    }
    cbvhReleaseContext(context);
    ASSERT_LT(n, 10000u);
  }
  refusesOnce = false;
}

// Memory also runs out while the error is reported.
TEST(CapiExhaustedHeap, ErrorsAreReturned) {
  CbvhContext context = nullptr;
  CbvhSurface surface = nullptr;
  ASSERT_EQ(cbvhNewContext(nullptr, nullptr, nullptr, &context), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhNewSurface(context, &surface), CBVH_OK);
  CbvhAccuracy accuracy = CbvhAccuracy();
  accuracy.maxPixelError = -1;
  unsigned numOutOfMemory = 0;
  for (unsigned n = 0;; n++) { // refuses all allocations after the first n
    SCOPED_TRACE(n);
    CbvhError error = CBVH_OK;
    bool isThrown = false;
    refused = 0;
    allowed = n;
    isExhausted = true;
    try {
      error = cbvhSetSurfaceAccuracy(surface, &accuracy);
    } catch (...) { isThrown = true; }
    isExhausted = false;
    allowed = 0;
    EXPECT_FALSE(isThrown);
    if (refused == 0) {
      EXPECT_EQ(error, CBVH_ERROR_INVALID_ARGUMENT);
      break;
    }
    EXPECT_TRUE(isThrown || error == CBVH_ERROR_OUT_OF_MEMORY || error == CBVH_ERROR_INVALID_ARGUMENT) << error;
    numOutOfMemory += error == CBVH_ERROR_OUT_OF_MEMORY;
  }
  EXPECT_GT(numOutOfMemory, 0u) << "no allocation was refused, so nothing is tested";
  cbvhReleaseSurface(surface);
  cbvhReleaseContext(context);
}

}} // namespace programs::test
