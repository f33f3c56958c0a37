// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays have the same hits in tiles as in the blocks of cVERT, to the bit, with every query: cages, also moving, with
 * stitched edges, holes, and vertices that are not finite; grids and meshes; at every precision; along axes, at
 * vertices, and with directions of any length. */

#include "support/irregular_mesh.h"
#include "support/moving_surface.h"
#include "support/odd_rays.h"
#include "support/query_forms.h"
#include "support/same_hits.h"
#include "support/saved.h"

#include <gtest/gtest.h>

namespace programs::test { namespace {

constexpr uint32_t seed = 91;

// any: queries for any hit
void expectSameBits(const std::vector<RTCRayHit>& expected, const std::vector<RTCRayHit>& found, size_t minHits,
                    bool any = false) {
  size_t hits = 0;
  for (size_t i = 0; i < expected.size(); i++) {
    hits += any ? expected[i].ray.tfar < 0 : isHit(expected[i]);
    ASSERT_EQ(std::memcmp(&expected[i], &found[i], sizeof(RTCRayHit)), 0)
        << "ray " << i << ": distances " << expected[i].ray.tfar << " and " << found[i].ray.tfar << ", primitives "
        << expected[i].hit.primID << " and " << found[i].hit.primID;
  }
  ASSERT_GE(hits, minHits);
}

class TileSurfaces : public testing::TestWithParam<const char*> {
protected:
  TileSurfaces() : device(std::string(GetParam())), random(seed) {}

  void SetUp() override {
    if (!device) GTEST_SKIP() << "this processor has no such instructions";
  }

  // The same scene in both forms.
  template<typename Add>
  void expectEqual(const std::vector<RTCRayHit>& rays, size_t minHits, const Add& add) {
    expectEqual(device, rays, minHits, add);
  }
  template<typename Add>
  static void expectEqual(Device& device, const std::vector<RTCRayHit>& rays, size_t minHits, const Add& add) {
    Scene blocks(device), tiles(device);
    add(blocks, RTC_COMPRESSION_CVERT);
    add(tiles, RTC_COMPRESSION_CTILE);
    rtcCommitScene(blocks);
    rtcCommitScene(tiles);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_EQ(statisticsOf(tiles).numQuads, statisticsOf(blocks).numQuads);
    EXPECT_NE(nodeAndLeafBytes(tiles), nodeAndLeafBytes(blocks))
        << "no tiles among " << statisticsOf(tiles).numQuads << " quads";
    for (QueryForm form : allQueryForms)
      for (bool any : {false, true}) {
        SCOPED_TRACE(testing::Message() << nameOf(form) << (any ? ", any hit" : ""));
        ASSERT_NO_FATAL_FAILURE(
            expectSameBits(QueryRun(blocks, form, any)(rays), QueryRun(tiles, form, any)(rays), minHits, any));
      }
  }

  void expectEqualCages(const Cage& cage, SurfaceSettings settings, const std::vector<RTCRayHit>& rays,
                        size_t minHits) {
    expectEqual(rays, minHits, [&](RTCScene scene, RTCCompression compression) {
      settings.compression = compression;
      addSurface(device, scene, cage, settings);
    });
  }

  std::vector<RTCRayHit> rays(unsigned count = 3000) { return raysAt(random, count); }

  Vec somewhere() {
    Vec position;
    for (int k = 0; k < 3; k++) position[k] = float(random.uniform(-0.8, 0.8));
    return position;
  }

  Device device;
  Random random;
};

TEST_P(TileSurfaces, CagesHaveTheHitsOfBlocks) {
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  const float precisions[] = {0.0f, 1e-7f, 1e-5f, 1e-3f};
  for (const Cage& cage : {cubeCage(), prismCage(5), trapezohedronCage(7)})
    for (float rate : {8.0f, 11.0f, 16.0f, 31.0f, 64.0f})
      for (float maxError : precisions) {
        if (maxError != 0 && rate != 31) continue;
        SCOPED_TRACE(testing::Message() << cage.faces.size() << " faces, rate " << rate << ", error " << maxError);
        settings.rate = rate;
        settings.maxError = maxError;
        ASSERT_NO_FATAL_FAILURE(expectEqualCages(cage, settings, rays(), 500));
      }
}

TEST_P(TileSurfaces, StitchedEdgesHolesAndInvalidVertices) {
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  Cage cage = cubeCage();
  for (size_t i = 0; i < cage.indices.size(); i++) settings.edgeRates.push_back(float(7 + 5 * (i % 7)));
  ASSERT_NO_FATAL_FAILURE(expectEqualCages(cage, settings, rays(), 500));
  cage.holes = {2};
  ASSERT_NO_FATAL_FAILURE(expectEqualCages(cage, settings, rays(), 500));
  settings.edgeRates.clear();
  displacement.poison = [](unsigned primID, float u, float v) { return primID == 1 && u > 0.4f && v > 0.7f; };
  ASSERT_NO_FATAL_FAILURE(expectEqual(rays(), 500, [&](RTCScene scene, RTCCompression compression) {
    settings.compression = compression;
    addSurface(device, scene, cage, settings);
    rtcCommitScene(scene);
    device.takeError(); // names the vertices
  }));
}

TEST_P(TileSurfaces, LosslessVertices) {
  Device lossless(std::string(GetParam()) + ",cbvh_max_error=0");
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  ASSERT_NO_FATAL_FAILURE(expectEqual(lossless, rays(), 500, [&](RTCScene scene, RTCCompression compression) {
    settings.compression = compression;
    addSurface(lossless, scene, cubeCage(), settings);
  }));
}

TEST_P(TileSurfaces, LargeSmallAndFlatSurfaces) {
  for (float scale : {1e-6f, 1.0f, 1e6f, 1e17f}) {
    Displacement displacement;
    displacement.scale = scale;
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.rate = 20;
    std::vector<RTCRayHit> scaled = rays();
    for (RTCRayHit& r : scaled)
      for (float* x : {&r.ray.org_x, &r.ray.org_y, &r.ray.org_z}) *x *= scale;
    ASSERT_NO_FATAL_FAILURE(expectEqualCages(sheetCage(3), settings, scaled, 100));
    displacement.amplitude = 0;
    ASSERT_NO_FATAL_FAILURE(expectEqualCages(quadCage(), settings, scaled, 10));
  }
}

TEST_P(TileSurfaces, RaysAtVerticesAndAlongAxes) {
  Displacement displacement;
  displacement.lattice = 1.0f / 256;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.rate = 24;
  settings.compression = RTC_COMPRESSION_CVERT;
  std::vector<Vec> vertices; // near hits
  for (const RTCRayHit& r : closestHits(SurfaceScene(device, cubeCage(), settings), rays(), QueryForm::Single))
    if (isHit(r))
      vertices.push_back({roundTo(r.ray.org_x + r.ray.tfar * r.ray.dir_x, 1.0 / 256),
                          roundTo(r.ray.org_y + r.ray.tfar * r.ray.dir_y, 1.0 / 256),
                          roundTo(r.ray.org_z + r.ray.tfar * r.ray.dir_z, 1.0 / 256)});
  const std::vector<RTCRayHit> next = raysNextToVertices(random, vertices, 2000);
  for (int exponent : oddExponents) {
    SCOPED_TRACE(exponent);
    ASSERT_NO_FATAL_FAILURE(
        expectEqualCages(cubeCage(), settings, withDirections(next, std::ldexp(1.0f, exponent)), 1000));
  }
  std::vector<RTCRayHit> spoiled = next;
  for (RTCRayHit& r : spoiled) spoil(r.ray, random);
  ASSERT_NO_FATAL_FAILURE(expectEqualCages(cubeCage(), settings, spoiled, 0));
}

TEST_P(TileSurfaces, GridsAndMeshes) {
  const Diced ball = dicedBall(2, 20);
  const std::vector<RTCRayHit> gridRays = raysAt(random, ball, 2000);
  ASSERT_NO_FATAL_FAILURE(expectEqual(gridRays, 1000, [&](RTCScene scene, RTCCompression compression) {
    attach(scene, newGrids(device, ball, compression));
  }));
  for (QuadOrder order : {QuadOrder::Rows, QuadOrder::Shuffled}) {
    const DicedMesh mesh = meshOf(ball, order, random);
    ASSERT_NO_FATAL_FAILURE(expectEqual(gridRays, 1000, [&](RTCScene scene, RTCCompression compression) {
      attach(scene, newMesh(device, mesh, compression));
    }));
  }
}

// Steps that turn slowly, or so fast that the tree splits time; all times, or a part of them.
TEST_P(TileSurfaces, MovingCages) {
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  for (unsigned timeSteps : {2u, 3u, 6u})
    for (float rate : {11.0f, 16.0f, 37.0f})
      for (bool isFast : {false, true}) {
        SCOPED_TRACE(testing::Message() << timeSteps << " steps, rate " << rate << (isFast ? ", fast" : ""));
        settings.timeSteps = timeSteps;
        settings.rate = rate;
        settings.maxError = rate == 11 ? 0.0f : 1e-4f;
        settings.motion = [isFast](const Vec& p, unsigned i) { return isFast ? orbiting(p, i) : twisted(p, 0.3 * i); };
        settings.begin = rate == 16 ? 0.25f : 0.0f;
        settings.end = rate == 16 ? 0.75f : 1.0f;
        std::vector<RTCRayHit> timed = timedRays(random, 2000);
        for (size_t i = 0; i < timed.size(); i += 10) timed[i].ray.time = float(i / 10 % 3) * 0.5f;
        if (isFast)
          for (RTCRayHit& r : timed) r.ray.org_x += 3.0f;
        ASSERT_NO_FATAL_FAILURE(expectEqualCages(prismCage(5), settings, timed, 40));
      }
}

TEST_P(TileSurfaces, MovingCagesWithStitchedEdgesHolesAndInvalidVertices) {
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.timeSteps = 4;
  Cage cage = cubeCage();
  for (size_t i = 0; i < cage.indices.size(); i++) settings.edgeRates.push_back(float(7 + 5 * (i % 7)));
  cage.holes = {2};
  ASSERT_NO_FATAL_FAILURE(expectEqualCages(cage, settings, timedRays(random, 3000), 500));
  settings.edgeRates.clear();
  displacement.poison = [](unsigned primID, float u, float v) { return primID == 1 && u > 0.4f && v > 0.7f; };
  ASSERT_NO_FATAL_FAILURE(expectEqual(timedRays(random, 3000), 500, [&](RTCScene scene, RTCCompression compression) {
    settings.compression = compression;
    addSurface(device, scene, cage, settings);
    rtcCommitScene(scene);
    device.takeError(); // names the vertices
  }));
}

// From the middle to vertices and edges.
TEST_P(TileSurfaces, MovingVerticesAndEdges) {
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = RTC_COMPRESSION_CVERT;
  settings.timeSteps = 3;
  settings.motion = [](const Vec& p, unsigned i) { return twisted(p, 0.3 * i); };
  const RTCGeometry geometry = newSurface(device, cubeCage(), settings);
  Scene scene(device); // compresses the geometry
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  const std::vector<RTCRayHit> aimed = raysAtMovingSurface(random, geometry, 12, 400);
  rtcReleaseGeometry(geometry);
  ASSERT_NO_FATAL_FAILURE(expectEqualCages(cubeCage(), settings, aimed, aimed.size()));
}

TEST_P(TileSurfaces, MovingGridsAndMeshes) {
  const Diced ball = dicedBall(2, 20);
  std::vector<RTCRayHit> timed = raysAt(random, ball, 2000);
  for (RTCRayHit& r : timed) r.ray.time = float(random.uniform());
  ASSERT_NO_FATAL_FAILURE(expectEqual(timed, 1000, [&](RTCScene scene, RTCCompression compression) {
    attach(scene, newGrids(device, ball, compression, 0, 3));
  }));
  for (QuadOrder order : {QuadOrder::Rows, QuadOrder::Shuffled}) {
    const DicedMesh mesh = meshOf(ball, order, random);
    ASSERT_NO_FATAL_FAILURE(expectEqual(timed, 1000, [&](RTCScene scene, RTCCompression compression) {
      attach(scene, newMesh(device, mesh, compression, 0, 3));
    }));
  }
}

// Mesh blocks become mesh tiles, also next to tiles of quads. Rays at vertices and edges on a lattice hit several
// triangles at the same distance.
TEST_P(TileSurfaces, IrregularMeshes) {
  for (double lattice : {1.0 / 64, 0.0}) {
    for (const NamedMesh& named : irregularMeshes(random, lattice)) {
      SCOPED_TRACE(named.name);
      std::vector<RTCRayHit> at = rays(2000);
      const std::vector<RTCRayHit> next = raysNextToVertices(random, named.mesh.vertices, 2000);
      at.insert(at.end(), next.begin(), next.end());
      ASSERT_NO_FATAL_FAILURE(expectEqual(at, 1000, [&](RTCScene scene, RTCCompression compression) {
        attach(scene, newMesh(device, named.mesh, compression));
      }));
    }
  }
}

TEST_P(TileSurfaces, MovingIrregularMeshes) {
  for (double lattice : {1.0 / 64, 0.0})
    for (NamedMesh& named : irregularMeshes(random, lattice)) {
      SCOPED_TRACE(named.name);
      std::vector<RTCRayHit> at = rays(2000);
      const std::vector<RTCRayHit> next = raysNextToVertices(random, named.mesh.vertices, 1000);
      at.insert(at.end(), next.begin(), next.end());
      for (size_t i = 0; i < at.size(); i++) at[i].ray.time = i < 2500 ? float(random.uniform()) : 0.0f;
      for (unsigned timeSteps : {2u, 4u}) {
        named.mesh.motion = [](const Vec& p, unsigned step) { return twisted(p, 0.1 * step); };
        ASSERT_NO_FATAL_FAILURE(expectEqual(at, 500, [&](RTCScene scene, RTCCompression compression) {
          attach(scene, newMesh(device, named.mesh, compression, 0, timeSteps));
        }));
      }
    }
}

TEST_P(TileSurfaces, MovingLargeSmallAndFlatSurfaces) {
  const Diced ball = dicedBall(2, 20);
  for (float scale : {1e-36f, 1e-6f, 1.0f, 1e6f, 1e17f}) {
    SCOPED_TRACE(scale);
    Displacement displacement;
    displacement.scale = scale;
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.rate = 20;
    settings.timeSteps = 3;
    settings.motion = [](const Vec& p, unsigned i) { return i == 1 ? Vec{p[0], p[1], 0.0f} : twisted(p, 0.3 * i); };
    std::vector<RTCRayHit> scaled = timedRays(random, 3000);
    for (RTCRayHit& r : scaled)
      for (float* x : {&r.ray.org_x, &r.ray.org_y, &r.ray.org_z}) *x *= scale;
    ASSERT_NO_FATAL_FAILURE(expectEqualCages(cubeCage(), settings, scaled, 100));
    DicedMesh irregular = irregularTriangles(meshOf(ball, QuadOrder::Shuffled, random), random);
    for (Vec& p : irregular.vertices)
      for (float& x : p) x *= scale;
    irregular.motion = [](const Vec& p, unsigned i) { return i == 1 ? Vec{2 * p[0], p[1], p[2]} : p; };
    ASSERT_NO_FATAL_FAILURE(expectEqual(scaled, 100, [&](RTCScene scene, RTCCompression compression) {
      attach(scene, newMesh(device, irregular, compression, 0, 3));
    }));
  }
}

// Many tiles are below nodes of 16 children, alone and next to other leaves, also to those that need Embree's nodes.
TEST_P(TileSurfaces, ManySurfaces) {
  std::vector<Displacement> displacements(60);
  for (size_t i = 0; i < displacements.size(); i++) {
    displacements[i].scale = i % 3 ? 0.15f : 0.4f;
    displacements[i].offset = somewhere();
  }
  const Diced ball = dicedBall(2, 20);
  enum class Beside { Nothing, SmallBlocks, Meshes, FramedBlocks, Grids };
  for (Beside beside : {Beside::Nothing, Beside::SmallBlocks, Beside::Meshes, Beside::FramedBlocks, Beside::Grids}) {
    SCOPED_TRACE(int(beside));
    ASSERT_NO_FATAL_FAILURE(expectEqual(rays(), 500, [&](RTCScene scene, RTCCompression compression) {
      Random same(seed);
      for (size_t i = 0; i < displacements.size(); i++) {
        SurfaceSettings settings;
        settings.displacement = &displacements[i];
        settings.rate = 17;
        settings.compression = compression;
        if (i % 2 == 0 && beside == Beside::SmallBlocks) settings.rate = 5;
        if (i % 8 == 0 && beside == Beside::FramedBlocks) settings.compression = RTC_COMPRESSION_CLEAF;
        if (i % 8 == 0 && beside == Beside::Grids) settings.compression = RTC_COMPRESSION_NONE;
        addSurface(device, scene, cubeCage(), settings);
      }
      if (beside == Beside::Meshes)
        attach(scene, newMesh(device, meshOf(ball, QuadOrder::Shuffled, same), compression));
    }));
  }
}

// Nodes follow the scene: without a surface, with another one, and without tiles.
TEST_P(TileSurfaces, EditsOfScenes) {
  std::vector<Displacement> displacements(20);
  for (Displacement& displacement : displacements) {
    displacement.scale = 0.3f;
    displacement.offset = somewhere();
  }
  const std::vector<RTCRayHit> some = rays();
  Scene blocks(device), tiles(device);
  std::vector<unsigned> ids[2];
  const auto add = [&](size_t i) {
    SurfaceSettings settings;
    settings.displacement = &displacements[i];
    for (bool areTiles : {false, true}) {
      settings.compression = areTiles ? RTC_COMPRESSION_CTILE : RTC_COMPRESSION_CVERT;
      ids[areTiles].push_back(addSurface(device, areTiles ? tiles : blocks, cubeCage(), settings));
    }
  };
  const auto expectSame = [&](size_t minHits) {
    rtcCommitScene(blocks);
    rtcCommitScene(tiles);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    expectSameBits(closestHits(blocks, some, QueryForm::Single), closestHits(tiles, some, QueryForm::Single), minHits);
  };
  for (size_t i = 0; i + 1 < displacements.size(); i++) add(i);
  ASSERT_NO_FATAL_FAILURE(expectSame(300));
  for (size_t i = 0; i < 10; i++) {
    rtcDetachGeometry(blocks, ids[0][i]);
    rtcDetachGeometry(tiles, ids[1][i]);
  }
  ASSERT_NO_FATAL_FAILURE(expectSame(100));
  add(displacements.size() - 1);
  ASSERT_NO_FATAL_FAILURE(expectSame(100));
  for (size_t i = 10; i < displacements.size(); i++) {
    rtcDetachGeometry(blocks, ids[0][i]);
    rtcDetachGeometry(tiles, ids[1][i]);
  }
  ASSERT_NO_FATAL_FAILURE(expectSame(0));
}

void expectEqualBytes(RTCScene a, RTCScene b) {
  const RTCCompressionStatistics x = statisticsOf(a), y = statisticsOf(b);
  EXPECT_EQ(x.headerBytes, y.headerBytes);
  EXPECT_EQ(x.nodeBytes, y.nodeBytes);
  EXPECT_EQ(x.leafBytes, y.leafBytes);
  EXPECT_EQ(x.numRawBlocks, y.numRawBlocks);
  EXPECT_EQ(x.motionBytes, y.motionBytes);
}

// Files contain blocks: as many bytes as those of cVERT, and the same hits. Devices that trace tiles make them of
// files, too.
TEST_P(TileSurfaces, FilesContainBlocks) {
  Device tileDevice(std::string(GetParam()) + ",subdiv_accel=cbvh.tile");
  const Folder folder;
  const Diced ball = dicedBall(2, 20);
  const DicedMesh mesh = meshOf(ball, QuadOrder::Shuffled, random), irregular = irregularTriangles(mesh, random),
                  irregularQuad = irregularQuads(mesh, random);
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.rate = 37;
  const std::function<RTCGeometry(RTCCompression)> makers[] = {
      [&](RTCCompression compression) {
        settings.compression = compression;
        return newSurface(device, cubeCage(), settings);
      },
      [&](RTCCompression compression) {
        SurfaceSettings moving = settings;
        moving.compression = compression;
        moving.timeSteps = 3;
        return newSurface(device, cubeCage(), moving);
      },
      [&](RTCCompression compression) { return newMesh(device, mesh, compression, 0, 4); },
      [&](RTCCompression compression) { return newMesh(device, irregular, compression, 0, 3); },
      [&](RTCCompression compression) { return newMesh(device, irregularQuad, compression, 0, 2); },
      [&](RTCCompression compression) { return newGrids(device, ball, compression); },
      [&](RTCCompression compression) { return newMesh(device, mesh, compression); },
      [&](RTCCompression compression) { return newMesh(device, irregular, compression); },
      [&](RTCCompression compression) { return newMesh(device, irregularQuad, compression); }};
  for (const auto& make : makers) {
    const std::string tiles = folder / "tiles", blocks = folder / "blocks";
    Scene traced(device), compressed(device), loaded(device), loadedTiles(tileDevice);
    for (RTCCompression compression : {RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CTILE}) {
      const RTCGeometry geometry = make(compression);
      Scene scene(device); // compresses the geometry
      rtcAttachGeometry(scene, geometry);
      rtcCommitScene(scene);
      const bool areTiles = compression == RTC_COMPRESSION_CTILE;
      ASSERT_TRUE(saveGeometryFile(geometry, (areTiles ? tiles : blocks).c_str())) << cbvhGetErrorText();
      rtcAttachGeometry(areTiles ? traced : compressed, geometry);
      rtcReleaseGeometry(geometry);
    }
    EXPECT_EQ(bytesOf(tiles).size(), bytesOf(blocks).size());
    attach(loaded, loadGeometryFile(device, tiles.c_str()));
    attach(loadedTiles, loadGeometryFile(tileDevice, blocks.c_str()));
    for (RTCScene scene : std::initializer_list<RTCScene>{traced, compressed, loaded, loadedTiles})
      rtcCommitScene(scene);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    ASSERT_EQ(tileDevice.takeError(), RTC_ERROR_NONE) << tileDevice.message;
    expectEqualBytes(loaded, compressed);
    expectEqualBytes(loadedTiles, traced);
    const std::vector<RTCRayHit> some = rays(), expected = closestHits(traced, some, QueryForm::Single);
    for (RTCScene scene : std::initializer_list<RTCScene>{loaded, loadedTiles})
      ASSERT_NO_FATAL_FAILURE(expectSameBits(expected, closestHits(scene, some, QueryForm::Single), 501));
  }
}

// The line of a commit names what is stored: blocks of few quads do not become tiles.
TEST_P(TileSurfaces, MessagesNameWhatIsStored) {
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CTILE;
  for (float rate : {4.0f, 16.0f}) {
    Device verbose(std::string(GetParam()) + ",verbose=1");
    settings.rate = rate;
    testing::internal::CaptureStderr();
    SurfaceScene scene(verbose, cubeCage(), settings);
    const std::string line = testing::internal::GetCapturedStderr();
    EXPECT_NE(line.find(rate == 4 ? "1 subdivision surface as cVERT: " : "1 subdivision surface as cTILE: "),
              std::string::npos)
        << line;
  }
}

INSTANTIATE_TEST_SUITE_P(Isa, TileSurfaces, testing::ValuesIn(std::vector<const char*>{TEST_ISAS}), nameOfIsa);

}} // namespace programs::test
