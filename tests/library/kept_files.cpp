// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Files in tests/library/kept_files, which earlier versions wrote: every later version decodes the same vertices and
 * finds the same hits. */

#include "kept_hits.h"

#include "cvert/decoder/decoded_block.h"
#include "cvert/decoder/decoded_mesh.h"
#include "cvert/file/checksum.h"
#include "cvert/file/file.h"
#include "cvert/file/tree_reader.h"
#include "support/hit_error.h"
#include "support/query_forms.h"
#include "support/same_hits.h"
#include "support/saved.h"
#include "support/surface_access.h"

#include <functional>
#include <memory>
#include <set>

namespace programs::test { namespace {

// --- what the files contain -------------------------------------------------------------------

const std::string folder = KEPT_FILES "/";

struct KeptFile {
  std::string name;                           // of NAME.cbvh and NAME.txt
  uint32_t vertVersion;                       // of the header: the newest version of its cVERT blocks
  uint32_t checksum;                          // of all bytes; 0 until the file is written
  std::function<RTCGeometry(RTCDevice)> make; // the encoder's input when the file was written

  std::string path() const { return folder + name + ".cbvh"; }
  bool isFramed() const { return name.compare(0, 6, "framed") == 0; }
  std::string textPath() const { return folder + name + ".txt"; }
};

Vec moved(const Vec& p, unsigned step) {
  const float s = 0.125f * float(step);
  return {p[0] + s, p[1], p[2] + s * p[0]};
}

RTCGeometry newCage(RTCDevice device, const Cage& cage, RTCCompression compression, float rate, unsigned timeSteps) {
  static Displacement displacement;
  displacement.lattice = 0x1p-10;
  SurfaceSettings settings;
  settings.rate = rate;
  settings.displacement = &displacement;
  settings.timeSteps = timeSteps;
  settings.begin = 0.25f;
  settings.end = 0.75f;
  settings.motion = moved;
  return releasing(newSurface(device, cage, settings), compression, RTC_COMPRESSION_FRAME_LEVEL_INHERIT, 0);
}

DicedMesh smallSheet(unsigned quads, Random& random) {
  DicedMesh sheet = meshOf(dicedSheet(1, quads, 0x1p-10), QuadOrder::Rows, random);
  sheet.motion = moved;
  return sheet;
}

// A grid of arbitrary floats, which needs remainders, and one with a NaN, which is stored as floats.
RTCGeometry newLosslessGrids(RTCDevice device) {
  Diced grids = dicedSheet(1, 12);
  grids.add(6, 5, [](unsigned x, unsigned y) {
    return Vec{0.15f * float(x) - 0.3f, 0.15f * float(y) - 0.3f, x == 2 && y == 1 ? NAN : 0.3f + 0.01f * float(x * y)};
  });
  RTCGeometry geometry = newGrids(device, grids);
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = RTC_COMPRESSION_CVERT;
  args.maxError = 0;
  args.flags = RTC_COMPRESSION_FLAG_RELEASE_INPUT;
  rtcSetGeometryCompression(geometry, &args);
  rtcCommitGeometry(geometry);
  return geometry;
}

RTCGeometry newKeptMesh(RTCDevice device, const DicedMesh& mesh, unsigned timeSteps) {
  return newMesh(device, mesh, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT, timeSteps);
}

std::vector<KeptFile> allKeptFiles() {
  return {{"framed1_leaves", 5, 0x22c5e68b,
           [](RTCDevice device) { return newCage(device, cubeCage(), RTC_COMPRESSION_CLEAF, 6, 1); }},
          {"vert5_cage", 5, 0x8cc4c716,
           [](RTCDevice device) { return newCage(device, sheetCage(5), RTC_COMPRESSION_CVERT, 4, 1); }},
          {"vert5_moving_cage", 5, 0x0a957573,
           [](RTCDevice device) { return newCage(device, sheetCage(2), RTC_COMPRESSION_CVERT, 5, 3); }},
          {"vert5_lossless_grids", 5, 0xfe82b268, newLosslessGrids},
          {"vert5_diced_triangles", 5, 0xccfd560d,
           [](RTCDevice device) {
             Random random(1);
             return newKeptMesh(device, withShuffledFaces(trianglesOf(smallSheet(14, random), 1, 2), random), 1);
           }},
          {"mesh6_triangles", 6, 0xa54c2ea9,
           [](RTCDevice device) {
             Random random(2);
             return newKeptMesh(device, irregularTriangles(smallSheet(12, random), random), 1);
           }},
          {"mesh7_moving_triangles", 7, 0xc7bc8410, [](RTCDevice device) {
             Random random(3);
             return newKeptMesh(device, irregularTriangles(smallSheet(12, random), random), 3);
           }}};
}

TEST(KeptFiles, EveryVersionHasOne) {
  std::set<uint32_t> versions;
  for (const KeptFile& kept : allKeptFiles()) versions.insert(kept.vertVersion);
  for (uint32_t version = cvert::oldestVertVersion; version <= cvert::movingMeshFormatVersion; version++)
    EXPECT_TRUE(versions.count(version)) << "add a file with blocks of version " << version;
}

// A file that was written again would test today's encoder instead of the bytes that users have.
TEST(KeptFiles, AreNeverWrittenAgain) {
  for (const KeptFile& kept : allKeptFiles()) {
    const std::string bytes = bytesOf(kept.path());
    EXPECT_EQ(cvert::fileChecksum(bytes.data(), bytes.size()), kept.checksum)
        << kept.path() << " changed: restore it, see README.md in its folder";
  }
}

// --- the codec alone --------------------------------------------------------------------------

struct AnyBlock {
  bool isMesh;
  const char* data;
  uint32_t numSteps;

  std::vector<Vec> vertices(uint32_t step) const {
    const auto copy = [](const float(*from)[3], size_t count) {
      std::vector<Vec> all(count);
      std::memcpy(all.data(), from, count * sizeof(Vec));
      return all;
    };
    if (isMesh) {
      const auto decoded = std::make_unique<cvert::DecodedMesh>((const cvert::MeshHeader*)data, step);
      return copy(decoded->vertices, decoded->numVertices);
    }
    const auto decoded = std::make_unique<cvert::DecodedBlock>((const cvert::VertHeader*)data, step);
    return copy(decoded->vertices, (decoded->quadsX + 1) * (decoded->quadsY + 1));
  }
};

// The blocks of a file with one geometry, without blocks with frames, which the codec does not decode.
std::vector<AnyBlock> blocksOf(const cvert::File& file) {
  std::vector<AnyBlock> all;
  const cvert::Reason reason =
      cvert::forEachBlock(file.geometry(0), file.tree(0), [&](cvert::FileChild type, uint64_t offset) {
        if (type != cvert::FILE_FRAMED)
          all.push_back({cvert::isMesh(type), file.blocks(0) + offset, file.geometry(0).numTimeSteps});
      });
  EXPECT_EQ(reason.message(), "");
  return all;
}

TEST(KeptFiles, AreDecodedToTheSameVertices) {
  for (const KeptFile& kept : allKeptFiles()) {
    SCOPED_TRACE(kept.name);
    const cvert::File file(kept.path());
    ASSERT_NO_THROW(file.verify());
    ASSERT_EQ(file.size(), 1u);
    cvert::FileHeader header;
    std::memcpy(&header, bytesOf(kept.path()).data(), sizeof(header));
    EXPECT_EQ(header.vertVersion, kept.vertVersion);
    const std::vector<AnyBlock> blocks = blocksOf(file);
    const KeptHits text = readKeptHits(kept.textPath());
    EXPECT_EQ(blocks.empty(), kept.isFramed());
    EXPECT_EQ(text.vertices.size(), kept.isFramed() ? 0u : 12u);
    for (const KeptVertex& expected : text.vertices) {
      ASSERT_LT(expected.block, blocks.size());
      ASSERT_LT(expected.step, blocks[expected.block].numSteps);
      const std::vector<Vec> vertices = blocks[expected.block].vertices(expected.step);
      ASSERT_LT(expected.index, vertices.size());
      EXPECT_EQ(std::memcmp(&vertices[expected.index], &expected.position, sizeof(Vec)), 0)
          << "block " << expected.block << ", step " << expected.step << ", vertex " << expected.index;
    }
  }
}

// --- Embree's library -------------------------------------------------------------------------

class LoadedScene : public Scene {
public:
  LoadedScene(RTCDevice device, const KeptFile& kept)
    : Scene(device),
      geometry(loadGeometryFile(device, kept.path().c_str())) {
    if (geometry) attach(*this, geometry);
    rtcCommitScene(*this);
  }
  const RTCGeometry geometry;
};

bool findTriangle(RTCGeometry geometry, const RTCRayHit& r, CbvhTriangle& triangle) {
  const RTCHit& hit = r.hit;
  return isHit(r) && findStoredTriangle(geometry, r.ray.time, hit.primID, hit.u, hit.v, &hit.Ng_x, &triangle);
}

// The hits in the text files were found with AVX2. Other instruction sets round u and v differently.
const std::string recordedIsa = "isa=avx2";

class KeptFileHits : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Isas, KeptFileHits, testing::Values(TEST_ISAS), nameOfIsa);

void expectEqual(const RTCRayHit& expected, const RTCRayHit& found) {
  EXPECT_EQ(expected.ray.tfar, found.ray.tfar);
  EXPECT_EQ(expected.hit.u, found.hit.u);
  EXPECT_EQ(expected.hit.v, found.hit.v);
  EXPECT_EQ(expected.hit.Ng_x, found.hit.Ng_x);
  EXPECT_EQ(expected.hit.Ng_y, found.hit.Ng_y);
  EXPECT_EQ(expected.hit.Ng_z, found.hit.Ng_z);
}

// t and the normal are rounded once, from doubles. u and v have the errors of floats, on both instruction sets.
void expectWithinRounding(RTCGeometry geometry, const RTCRayHit& expected, const RTCRayHit& found) {
  CbvhTriangle triangle;
  ASSERT_TRUE(findTriangle(geometry, found, triangle));
  const HitError error = ExactTriangleHit(found.ray, triangle).oursBound();
  EXPECT_NEAR(expected.ray.tfar, found.ray.tfar, ulpOf(expected.ray.tfar));
  EXPECT_NEAR(expected.hit.u, found.hit.u, 2 * error.u);
  EXPECT_NEAR(expected.hit.v, found.hit.v, 2 * error.v);
  const RTCHit &e = expected.hit, &f = found.hit;
  const double ulp = ulpOf(std::max({std::fabs(e.Ng_x), std::fabs(e.Ng_y), std::fabs(e.Ng_z)}));
  EXPECT_NEAR(e.Ng_x, f.Ng_x, ulp);
  EXPECT_NEAR(e.Ng_y, f.Ng_y, ulp);
  EXPECT_NEAR(e.Ng_z, f.Ng_z, ulp);
}

TEST_P(KeptFileHits, AreTheSame) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  for (const KeptFile& kept : allKeptFiles()) {
    SCOPED_TRACE(kept.name);
    const KeptHits text = readKeptHits(kept.textPath());
    const LoadedScene scene(device, kept);
    ASSERT_NE(scene.geometry, nullptr) << device.message;
    ASSERT_GE(text.rays.size(), 30u);
    ASSERT_GT(std::count_if(text.hits.begin(), text.hits.end(), isHit), 20);
    for (QueryForm form : allQueryForms) {
      SCOPED_TRACE(nameOf(form));
      const std::vector<RTCRayHit> found = closestHits(scene, text.rays, form);
      if (GetParam() != recordedIsa && kept.isFramed()) {
        expectSameHits(text.hits, found); // leaves with frames are intersected in floats
        continue;
      }
      for (size_t i = 0; i < found.size(); i++) {
        SCOPED_TRACE(testing::Message() << "ray " << i);
        ASSERT_EQ(isHit(text.hits[i]), isHit(found[i]));
        if (!isHit(found[i])) continue;
        ASSERT_EQ(text.hits[i].hit.primID, found[i].hit.primID);
        if (GetParam() == recordedIsa) expectEqual(text.hits[i], found[i]);
        else expectWithinRounding(scene.geometry, text.hits[i], found[i]);
      }
    }
  }
  EXPECT_EQ(device.errors, 0u) << device.message;
}

// --- files of new versions --------------------------------------------------------------------

// Hits are not near an edge of their triangle. Vertices that move from one lattice to another are floats at multiples
// of 1/16 of the time range, so interpolation is exact. geometry: null if its triangles cannot be read.
void addRays(Random& random, RTCScene scene, RTCGeometry geometry, float begin, float end, KeptHits& all) {
  unsigned misses = 0;
  while (all.rays.size() < 32) {
    RTCRayHit ray = raysAt(random, 1)[0];
    ray.ray.time = begin + 0.0625f * float(random.below(17)) * (end - begin);
    const RTCRayHit hit = intersect(scene, ray);
    CbvhTriangle triangle;
    if (geometry && findTriangle(geometry, hit, triangle)) {
      const ExactTriangleHit exact(ray.ray, triangle);
      if (std::min({exact.weights[0], exact.weights[1], exact.weights[2]}) < 0.05 || exact.cosine < 0.2) continue;
    }
    if (!isHit(hit) && ++misses > 6) continue;
    all.rays.push_back(ray);
    all.hits.push_back(hit);
  }
}

/* Writes files of new versions: add a file without checksum to allKeptFiles and run
 *
 *     test_kept_files --gtest_also_run_disabled_tests --gtest_filter=*WriteMissing
 *
 * Then add the checksum that it prints. Files that exist are skipped. */
TEST(KeptFiles, DISABLED_WriteMissing) {
  Device device(recordedIsa);
  for (const KeptFile& kept : allKeptFiles()) {
    if (kept.checksum || !bytesOf(kept.path()).empty()) continue;
    RTCGeometry geometry = kept.make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, kept.path().c_str())) << device.message;
    rtcReleaseGeometry(geometry);
    KeptHits all;
    Random random(4);
    const cvert::File file(kept.path());
    const std::vector<AnyBlock> blocks = blocksOf(file);
    for (unsigned i = 0; i < (blocks.empty() ? 0u : 12u); i++) {
      const unsigned block = i % unsigned(blocks.size()), step = random.below(blocks[block].numSteps);
      const std::vector<Vec> vertices = blocks[block].vertices(step);
      const unsigned index = random.below(unsigned(vertices.size()));
      all.vertices.push_back({block, step, index, vertices[index]});
    }
    const LoadedScene scene(device, kept);
    const cvert::FileGeometry& record = file.geometry(0);
    addRays(random, scene, kept.isFramed() ? nullptr : scene.geometry, record.begin, record.end, all);
    writeKeptHits(kept.textPath(), kept.name + ".cbvh", all);
    const std::string bytes = bytesOf(kept.path());
    std::printf("%s: %zu bytes, checksum 0x%08x, form %u, blocks %zu\n", kept.name.c_str(), bytes.size(),
                cvert::fileChecksum(bytes.data(), bytes.size()), record.form, size_t(record.numBlocks));
  }
  EXPECT_EQ(device.errors, 0u) << device.message;
}

}} // namespace programs::test
