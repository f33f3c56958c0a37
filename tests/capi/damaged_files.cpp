// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Damaged files: the context's error function is called with the reason, once per surface if rays detect the
 * damage. */

#include "support/file_mutations.h"
#include "support/message_parts.h"

#include <cbvh/cbvh.h>
#include <gtest/gtest.h>

namespace programs::test { namespace {

struct Reported {
  unsigned errors = 0;
  CbvhError code = CBVH_OK;
  std::string text;

  static void function(void* self, CbvhError code, const char* text) {
    Reported& reported = *(Reported*)self;
    reported.errors++;
    reported.code = code;
    reported.text = text;
    cbvhReleaseContext(nullptr); // functions of the library may be called in callbacks
  }
};

struct Damaged : testing::Test {
  Reported reported;
  CbvhContext context = nullptr;
  Folder folder;
  const std::string path = folder / "surface.cbvh";
  std::string whole;

  Damaged() {
    EXPECT_EQ(cbvhNewContext(nullptr, Reported::function, &reported, &context), CBVH_OK);
    const Cage cage = cubeCage();
    const float* const steps[] = {cage.positions[0].data()};
    CbvhCage input = CbvhCage();
    input.numFaces = cage.faces.size();
    input.faceVertexCounts = cage.faces.data();
    input.numIndices = cage.indices.size();
    input.indices = cage.indices.data();
    input.vertices = {cage.positions.size(), sizeof(Vec), steps, 1, 0, 1};
    input.rate = 64;
    CbvhSurface surface = nullptr;
    EXPECT_EQ(cbvhNewSurface(context, &surface), CBVH_OK);
    EXPECT_EQ(cbvhSetSurfaceCage(surface, &input), CBVH_OK) << cbvhGetErrorText();
    EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
    EXPECT_EQ(cbvhSaveSurface(surface, path.c_str()), CBVH_OK) << cbvhGetErrorText();
    cbvhReleaseSurface(surface);
    whole = bytesOf(path);
    damage(0);
  }
  ~Damaged() override { cbvhReleaseContext(context); }

  // Sets the first or the second half of the blocks to zero.
  void damage(int half) {
    FileBytes file(whole);
    const uint64_t bytes = file.record(0).blockBytes / 2, begin = file.record(0).blocks + (half ? bytes : 0);
    std::fill_n(file.bytes.begin() + ptrdiff_t(begin), bytes, '\0');
    writeBytes(path, file.bytes);
  }

  CbvhGroup load() {
    CbvhSurface surface = nullptr;
    CbvhGroup group = nullptr;
    EXPECT_EQ(cbvhLoadSurface(context, path.c_str(), &surface), CBVH_OK) << cbvhGetErrorText();
    EXPECT_EQ(cbvhNewGroup(context, &surface, 1, &group), CBVH_OK) << cbvhGetErrorText();
    EXPECT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();
    cbvhReleaseSurface(surface);
    EXPECT_EQ(reported.errors, 0u) << reported.text;
    return group;
  }

  // One error, which names the file and a block of its damaged first half.
  void expectOne(CbvhError code) {
    EXPECT_EQ(reported.errors, 1u);
    EXPECT_EQ(reported.code, code);
    ASSERT_TRUE(containsInOrder(reported.text, {path, "block"}));
    const char* const digits = "0123456789";
    const size_t block = reported.text.find("block", reported.text.find(path) + path.size());
    const size_t at = reported.text.find_first_of(digits, block);
    ASSERT_NE(at, std::string::npos) << reported.text;
    const unsigned long long offset = std::stoull(reported.text.substr(at));
    EXPECT_EQ(offset % 16, 0u) << reported.text;
    EXPECT_LT(offset, FileBytes(whole).record(0).blockBytes / 2) << reported.text;
    reported = Reported();
  }

  static std::vector<RTCRayHit> rays() {
    Random random(3);
    return raysAt(random, 2000);
  }
};

void traceSingle(CbvhGroup group, const std::vector<RTCRayHit>& rays) {
  for (const RTCRayHit& r : rays) {
    CbvhRayHit hit;
    std::memset(&hit, 0, sizeof(hit));
    hit.ray.org_x = r.ray.org_x;
    hit.ray.org_y = r.ray.org_y;
    hit.ray.org_z = r.ray.org_z;
    hit.ray.dir_x = r.ray.dir_x;
    hit.ray.dir_y = r.ray.dir_y;
    hit.ray.dir_z = r.ray.dir_z;
    hit.ray.tfar = r.ray.tfar;
    hit.ray.mask = ~0u;
    cbvhIntersect1(group, &hit, nullptr);
  }
}

void tracePackets(CbvhGroup group, const std::vector<RTCRayHit>& rays) {
  for (size_t first = 0; first + 8 <= rays.size(); first += 8) {
    RTCRay8 packet;
    std::memset(&packet, 0, sizeof(packet));
    int valid[8];
    for (size_t i = 0; i < 8; i++) {
      const RTCRay& r = rays[first + i].ray;
      valid[i] = -1;
      packet.org_x[i] = r.org_x;
      packet.org_y[i] = r.org_y;
      packet.org_z[i] = r.org_z;
      packet.dir_x[i] = r.dir_x;
      packet.dir_y[i] = r.dir_y;
      packet.dir_z[i] = r.dir_z;
      packet.tfar[i] = r.tfar;
      packet.mask[i] = ~0u;
    }
    cbvhOccluded8(group, valid, &packet, nullptr);
  }
}

TEST_F(Damaged, IsReportedByRays) {
  for (const auto& [name, trace] :
       {std::make_pair("single rays", traceSingle), std::make_pair("packets, any hit", tracePackets)}) {
    SCOPED_TRACE(name);
    CbvhGroup group = load();
    trace(group, rays());
    EXPECT_EQ(cbvhGetErrorText(), reported.text);
    expectOne(CBVH_ERROR_INVALID_ARGUMENT);
    cbvhReleaseGroup(group);
  }
}

TEST_F(Damaged, IsReportedByFunctionsThatReadAllBlocks) {
  const auto parts = [](CbvhSurface surface) {
    return cbvhForEachPart(surface, 0, [](void*, const CbvhPart*) { return 1; }, nullptr);
  };
  const auto clusters = [](CbvhSurface surface) {
    return cbvhForEachCluster(surface, 0, CBVH_CLUSTER_FORMAT_FLOAT3, nullptr, nullptr, nullptr);
  };
  for (const auto& [name, call] : {std::make_pair("parts", +parts), std::make_pair("clusters", +clusters)}) {
    SCOPED_TRACE(name);
    CbvhGroup group = load();
    EXPECT_EQ(call(cbvhGetGroupSurface(group, 0)), CBVH_ERROR_INVALID_OPERATION);
    EXPECT_EQ(cbvhGetErrorText(), reported.text);
    expectOne(CBVH_ERROR_INVALID_OPERATION);
    cbvhReleaseGroup(group);
  }
}

// The first block is in one of the halves: damage of the other one is detected after some clusters.
TEST_F(Damaged, ReportContainsSumsOfClustersBeforeIt) {
  const CbvhClusterFunction add = [](void* ptr, const CbvhCluster* cluster) {
    CbvhClusterStatistics& sums = *(CbvhClusterStatistics*)ptr;
    sums.numClusters++;
    sums.numTriangles += cluster->numTriangles;
    sums.bytes += cluster->bytes;
    return 1;
  };
  size_t most = 0;
  for (int half : {0, 1}) {
    damage(half);
    CbvhGroup group = load();
    CbvhClusterStatistics sums = CbvhClusterStatistics(), report = CbvhClusterStatistics();
    report.numClusters = report.numTriangles = report.bytes = report.numClustersByReason[3] = 12345;
    EXPECT_EQ(cbvhForEachCluster(cbvhGetGroupSurface(group, 0), 0, CBVH_CLUSTER_FORMAT_FLOAT3, add, &sums, &report),
              CBVH_ERROR_INVALID_OPERATION);
    EXPECT_EQ(report.numClusters, sums.numClusters);
    EXPECT_EQ(report.numTriangles, sums.numTriangles);
    EXPECT_EQ(report.bytes, sums.bytes);
    EXPECT_EQ(report.numClustersByReason[3], 0u);
    most = std::max(most, report.numClusters);
    reported = Reported();
    cbvhReleaseGroup(group);
  }
  EXPECT_GT(most, 0u);
}

// A callback traces rays while another object is committed: the commit must succeed.
TEST_F(Damaged, DoesNotFailTheCallThatInvokedACallback) {
  struct Callback {
    CbvhGroup group;
    std::vector<RTCRayHit> rays;
  } callback = {load(), rays()};
  const float vertices[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0};
  const float* const steps[] = {vertices};
  const unsigned faces[] = {4}, indices[] = {0, 1, 2, 3};
  CbvhCage input = CbvhCage();
  input.numFaces = 1;
  input.faceVertexCounts = faces;
  input.numIndices = 4;
  input.indices = indices;
  input.vertices = {4, sizeof(Vec), steps, 1, 0, 1};
  input.rate = 16;
  CbvhSurface surface = nullptr;
  ASSERT_EQ(cbvhNewSurface(context, &surface), CBVH_OK);
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &input), CBVH_OK) << cbvhGetErrorText();
  const CbvhProgressFunction progress = [](void* ptr, double) {
    traceSingle(((Callback*)ptr)->group, ((Callback*)ptr)->rays);
    return 1;
  };
  EXPECT_EQ(cbvhCommitSurface(surface, progress, &callback), CBVH_OK) << cbvhGetErrorText();
  expectOne(CBVH_ERROR_INVALID_ARGUMENT);
  cbvhReleaseSurface(surface);
  cbvhReleaseGroup(callback.group);
}

}} // namespace programs::test
