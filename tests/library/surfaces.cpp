// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Bridges between Embree's geometries and surfaces of cbvh.h, in a program that links only libembree3. */

#include "support/message_parts.h"
#include "support/saved.h"
#include "support/surface_access.h"

#include <cstring>
#include <tuple>

namespace programs::test { namespace {

const float cubeVertices[] = {-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1, 0};
const unsigned cubeFaces[] = {4, 4, 4, 4, 4, 4},
               cubeIndices[] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
const float* const cubeSteps[] = {cubeVertices};

CbvhCage cube() {
  CbvhCage cage;
  cage.numFaces = 6;
  cage.faceVertexCounts = cubeFaces;
  cage.numIndices = 24;
  cage.indices = cubeIndices;
  cage.vertices = {8, 12, cubeSteps, 1, 0, 1};
  cage.rate = 16;
  return cage;
}

RTCGeometry smoothCube(RTCDevice device, unsigned flags = 0) {
  SurfaceSettings settings;
  settings.rate = 16;
  RTCGeometry geometry = newSurface(device, cubeCage(), settings);
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = RTC_COMPRESSION_CVERT;
  args.flags = flags;
  rtcSetGeometryCompression(geometry, &args);
  return geometry;
}

size_t trianglesOf(CbvhSurface surface) {
  CbvhClusterStatistics statistics;
  EXPECT_EQ(cbvhForEachCluster(surface, 0, CBVH_CLUSTER_FORMAT_FLOAT3, nullptr, nullptr, &statistics), CBVH_OK)
      << cbvhGetErrorText();
  return statistics.numTriangles;
}

TEST(Surfaces, SurfaceOfADeviceBecomesAGeometryWithTheSameHits) {
  Device device;
  const ContextOfDevice context(device);
  CbvhSurface surface = nullptr;
  CbvhGroup group = nullptr;
  const CbvhCage cage = cube();
  ASSERT_EQ(cbvhNewSurface(context, &surface), CBVH_OK);
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK) << cbvhGetErrorText();
  EXPECT_EQ(rtcNewGeometryFromSurface(device, surface), nullptr) << "not committed";
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  const ContextOfDevice equivalent(device);
  ASSERT_EQ(cbvhNewGroup(equivalent, &surface, 1, &group), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();
  Scene scene(device);
  RTCGeometry geometry = rtcNewGeometryFromSurface(device, surface);
  ASSERT_NE(geometry, nullptr) << device.message;
  RTCGeometry again = rtcNewGeometryFromSurface(device, surface);
  EXPECT_EQ(again, geometry);
  rtcReleaseGeometry(again);
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK);
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << "the geometry keeps the former commit";
  cbvhReleaseSurface(surface);
  attach(scene, geometry);
  rtcCommitScene(scene);
  Random random(1);
  size_t hits = 0;
  for (const RTCRayHit& ray : raysAt(random, 300)) {
    CbvhRayHit other;
    std::memcpy((void*)&other, &ray, sizeof(other));
    other.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    const bool isFound = cbvhIntersect1(group, &other, nullptr) != 0;
    const RTCRayHit expected = intersect(scene, ray);
    ASSERT_EQ(isFound, isHit(expected));
    if (!isFound) continue;
    hits++;
    EXPECT_EQ(std::tie(other.ray.tfar, other.hit.u, other.hit.v, other.hit.primID, other.hit.Ng_x),
              std::tie(expected.ray.tfar, expected.hit.u, expected.hit.v, expected.hit.primID, expected.hit.Ng_x));
  }
  EXPECT_GT(hits, 50u);
  cbvhReleaseGroup(group);
  EXPECT_EQ(device.errors, 1u) << device.message;
}

TEST(Surfaces, SurfaceFollowsTheCommitsOfItsGeometry) {
  Device device;
  Scene scene(device);
  RTCGeometry geometry = smoothCube(device);
  const SurfaceOfGeometry surface(geometry);
  EXPECT_EQ(cbvhGetSurfacePrimitiveCount(surface), 6u);
  EXPECT_EQ(cbvhForEachCluster(surface, 0, CBVH_CLUSTER_FORMAT_FLOAT3, nullptr, nullptr, nullptr),
            CBVH_ERROR_INVALID_OPERATION)
      << "not committed";
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  EXPECT_EQ(trianglesOf(surface), 6u * 16 * 16 * 2);
  rtcSetGeometryTessellationRate(geometry, 8);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_EQ(trianglesOf(surface), 6u * 8 * 8 * 2);
  RTCGeometry same = rtcNewGeometryFromSurface(device, surface);
  EXPECT_EQ(same, geometry);
  rtcReleaseGeometry(same);
  rtcReleaseGeometry(geometry);
}

TEST(Surfaces, FilesOfDevicesAndOfContextsAreTheSameBytes) {
  Device device;
  const Folder folder;
  const RTCGeometry geometry = smoothCube(device, RTC_COMPRESSION_FLAG_RELEASE_INPUT);
  rtcCommitGeometry(geometry);
  EXPECT_EQ(cbvhSaveSurface(SurfaceOfGeometry(geometry), (folder / "geometry").c_str()), CBVH_OK);
  rtcReleaseGeometry(geometry);
  CbvhContext context = nullptr;
  CbvhSurface surface = nullptr;
  CbvhFile file = nullptr;
  ASSERT_EQ(cbvhNewContext(nullptr, nullptr, nullptr, &context), CBVH_OK);
  ASSERT_EQ(cbvhOpenFile(context, (folder / "geometry").c_str(), &file), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhLoadFileSurface(file, 0, &surface), CBVH_OK) << cbvhGetErrorText();
  CbvhFileWriter writer = nullptr;
  ASSERT_EQ(cbvhNewFileWriter(context, (folder / "surfaces").c_str(), &writer), CBVH_OK);
  for (size_t i = 0; i < 3; i++) {
    EXPECT_EQ(cbvhGetFileWriterSurfaceCount(writer), i);
    EXPECT_EQ(cbvhAppendSurface(writer, surface), CBVH_OK) << cbvhGetErrorText();
  }
  EXPECT_EQ(cbvhCommitFileWriter(writer), CBVH_OK) << cbvhGetErrorText();
  EXPECT_EQ(cbvhSaveSurface(surface, (folder / "surface").c_str()), CBVH_OK) << cbvhGetErrorText();
  EXPECT_EQ(bytesOf(folder / "geometry"), bytesOf(folder / "surface"));
  EXPECT_EQ(rtcNewGeometryFromSurface(device, surface), nullptr);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {"another device"}));
  cbvhReleaseFileWriter(writer);
  cbvhReleaseFile(file);
  cbvhReleaseSurface(surface);
  cbvhReleaseContext(context);
  CbvhFile several = openFile(device, (folder / "surfaces").c_str());
  EXPECT_EQ(countOf(several), 3u);
  EXPECT_TRUE(verifyFile(several));
  releaseFile(several);
}

TEST(Surfaces, OnlyTheApplicationChangesItsGeometry) {
  Device device;
  const ContextOfDevice context(device);
  RTCGeometry geometry = smoothCube(device);
  rtcCommitGeometry(geometry);
  const SurfaceOfGeometry surface(geometry);
  const CbvhCage cage = cube();
  const CbvhSurface surfaces[] = {surface};
  CbvhGroup group = nullptr;
  for (const CbvhError error : {cbvhSetSurfaceCage(surface, &cage), cbvhSetSurfaceAccuracy(surface, nullptr),
                                cbvhSetSurfaceLossless(surface, 1), cbvhSetSurfaceMask(surface, 1),
                                cbvhCommitSurface(surface, nullptr, nullptr)})
    EXPECT_EQ(error, CBVH_ERROR_INVALID_OPERATION);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_TRUE(containsInOrder(device.message, {"geometry", "rtcore.h"}));
  EXPECT_EQ(cbvhNewGroup(context, surfaces, 1, &group), CBVH_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(group, nullptr);
  rtcReleaseGeometry(geometry);
}

TEST(Surfaces, ErrorsOfEmbreeAreReturnedAndReportedOnce) {
  Device device;
  const ContextOfDevice context(device);
  CbvhSurface surface = nullptr;
  ASSERT_EQ(cbvhNewSurface(context, &surface), CBVH_OK);
  const CbvhCage cage = cube();
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK);
  EXPECT_EQ(cbvhCommitSurface(surface, [](void*, double) { return 0; }, nullptr), CBVH_ERROR_CANCELLED);
  EXPECT_EQ(device.errors, 1u);
  EXPECT_EQ(device.takeError(), RTC_ERROR_CANCELLED);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE);
  EXPECT_STREQ(cbvhGetErrorText(), device.message.c_str());
  EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << "the surface keeps its input";
  cbvhReleaseSurface(surface);
}

TEST(Surfaces, NullIsAnErrorOfTheThread) {
  Device device;
  EXPECT_EQ(rtcNewContextFromDevice(nullptr), nullptr);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(rtcNewSurfaceFromGeometry(nullptr), nullptr);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(rtcNewGeometryFromSurface(nullptr, nullptr), nullptr);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(rtcNewGeometryFromSurface(device, nullptr), nullptr);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
}

}} // namespace programs::test
