// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Counters of rtcGetSceneCompressionStatistics, and the times at which they are valid. */

#include "support/file_mutations.h"
#include "support/irregular_mesh.h"
#include "support/scene.h"
#include "support/surface_access.h"

#include <algorithm>
#include <cmath>

namespace programs::test { namespace {

RTCCompressionStatistics statisticsOf(RTCDevice device,
                                      const std::vector<std::pair<const Cage*, const SurfaceSettings*>>& surfaces) {
  Scene scene(device);
  for (const auto& surface : surfaces) addSurface(device, scene, *surface.first, *surface.second);
  rtcCommitScene(scene);
  return programs::test::statisticsOf(scene);
}

// Compares all bytes, so that members of later versions are included.
bool isAllZero(const RTCCompressionStatistics& s) {
  static const char zeros[sizeof(s)] = {};
  const size_t members = sizeof(s.structSize);
  return std::memcmp((const char*)&s + members, zeros, sizeof(s) - members) == 0;
}

// Both surfaces contribute to each counter. A scene with both must have the sums, except for the tree above them.
TEST(CompressionStatistics, AddUpOverSurfaces) {
  Device device;
  Cage many = sheetCage(6), few = cubeCage(); // one with several tasks, one with a single task
  Displacement rough, rougher;
  rough.amplitude = 0.4f;
  rougher.amplitude = 0.9f;
  rough.poison = [](unsigned primID, float u, float v) { return primID == 7 && u == 0 && v == 0; };
  rougher.poison = [](unsigned primID, float u, float v) { return primID == 3 && u == 1 && v == 1; };
  SurfaceSettings settings[2];
  const Cage* cages[2] = {&many, &few};
  Displacement* displacements[2] = {&rough, &rougher};
  RTCCompressionStatistics alone[2];
  for (int i = 0; i < 2; i++) {
    settings[i].displacement = displacements[i];
    settings[i].compression = RTC_COMPRESSION_CLEAF;
    settings[i].frameLevel = 1; // blocks small enough that some have only an affine frame
    settings[i].edgeRates.assign(cages[i]->indices.size(), 16.0f);
    std::fill_n(settings[i].edgeRates.end() - 4, 4, 257.0f); // the last face, which includes edges of its neighbors
    alone[i] = statisticsOf(device, {{cages[i], &settings[i]}});
    for (size_t n : {alone[i].headerBytes, alone[i].nodeBytes, alone[i].leafBytes, alone[i].uncompressedBytes,
                     alone[i].numBlocks, alone[i].numQuads, alone[i].numUncompressedQuads, alone[i].numInvalidQuads,
                     alone[i].numAffineBlocks, alone[i].numSolidLeaves})
      EXPECT_GT(n, 0u) << "surface " << i << " must contribute to every counter";
  }
  const RTCCompressionStatistics both = statisticsOf(device, {{cages[0], &settings[0]}, {cages[1], &settings[1]}});
  for (size_t RTCCompressionStatistics::* field :
       {&RTCCompressionStatistics::headerBytes, &RTCCompressionStatistics::nodeBytes,
        &RTCCompressionStatistics::leafBytes, &RTCCompressionStatistics::uncompressedBytes,
        &RTCCompressionStatistics::numBlocks, &RTCCompressionStatistics::numQuads,
        &RTCCompressionStatistics::numUncompressedQuads, &RTCCompressionStatistics::numInvalidQuads,
        &RTCCompressionStatistics::numAffineBlocks, &RTCCompressionStatistics::numSolidLeaves})
    EXPECT_EQ(both.*field, alone[0].*field + alone[1].*field);
  EXPECT_EQ(both.maxLeafThickness, std::max(alone[0].maxLeafThickness, alone[1].maxLeafThickness));
  EXPECT_GE(both.topLevelBytes, std::max(alone[0].topLevelBytes, alone[1].topLevelBytes));
}

// Blocks are aligned to 16 bytes.
TEST(CompressionStatistics, BytesOfBlocksIncludePadding) {
  Device device;
  Displacement displacement;
  const Cage cage = quadCage();
  for (RTCCompression kind : {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF})
    for (int height = 0; height <= 3; height++) {
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.compression = kind;
      settings.rate = 8;
      settings.frameLevel = 3 - height;
      const RTCCompressionStatistics s = statisticsOf(device, {{&cage, &settings}});
      EXPECT_EQ(s.numBlocks, size_t(64) >> 2 * height);
      EXPECT_EQ((s.headerBytes + s.nodeBytes + s.leafBytes) / s.numBlocks % 16, 0u)
          << "height " << height << ", kind " << kind;
    }
}

// The corners of a trapezoid have a projective map; the corners of a dented quad have none.
TEST(CompressionStatistics, AffineBlocksAreCounted) {
  Device device;
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CLEAF;
  settings.rate = 8;
  settings.frameLevel = 0;
  Cage trapezoid = quadCage(), dented = quadCage();
  trapezoid.positions[2] = {0.7f, 1, 0};
  dented.positions[2] = {0.4f, 0.4f, 0};
  for (const Cage* cage : {&trapezoid, &dented}) {
    const RTCCompressionStatistics s = statisticsOf(device, {{cage, &settings}});
    EXPECT_EQ(s.numBlocks, 1u);
    EXPECT_EQ(s.numAffineBlocks, cage == &dented ? 1u : 0u);
  }
}

TEST(CompressionStatistics, DescribeTheLastCommit) {
  Device device;
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CLEAF;
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  addSurface(device, scene, quadCage(), settings);
  rtcCommitScene(scene);
  EXPECT_GT(statisticsOf(scene).numBlocks, 0u);
  RTCGeometry geometry = rtcGetGeometry(scene, 0);
  // every face is at a border, so this mode removes all of them
  rtcSetGeometrySubdivisionMode(geometry, 0, RTC_SUBDIVISION_MODE_NO_BOUNDARY);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  RTCCompressionStatistics statistics = statisticsOf(scene);
  EXPECT_GT(statistics.inputBytes, 0u);
  statistics.inputBytes = 0;
  EXPECT_TRUE(isAllZero(statistics));
}

TEST(CompressionStatistics, AreRejectedUntilChangesAreCommitted) {
  Device device;
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CLEAF;
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  addSurface(device, scene, cubeCage(), settings);
  const unsigned second = addSurface(device, scene, quadCage(), settings);
  rtcCommitScene(scene);
  RTCGeometry geometry = rtcGetGeometry(scene, 0);
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = RTC_COMPRESSION_CVOXEL;
  const std::pair<const char*, std::function<void()>> changes[] = {
      {"vertices", [&] { rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0); }},
      {"compression", [&] { rtcSetGeometryCompression(geometry, &args); }},
      {"detached", [&] { rtcDetachGeometry(scene, second); }},
      {"attached", [&] { addSurface(device, scene, quadCage(), settings); }}};
  for (const auto& change : changes) {
    SCOPED_TRACE(change.first);
    EXPECT_GT(statisticsOf(scene).numBlocks, 0u);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    change.second();
    statisticsOf(scene);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
  }
}

TEST(CompressionStatistics, IgnoreDisabledSurfaces) {
  Device device;
  SurfaceSettings settings;
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  addSurface(device, scene, quadCage(), settings);
  settings.compression = RTC_COMPRESSION_CLEAF;
  RTCGeometry compressed = newSurface(device, cubeCage(), settings);
  rtcDisableGeometry(compressed);
  const unsigned id = attach(scene, compressed);
  rtcCommitScene(scene);
  EXPECT_TRUE(isAllZero(statisticsOf(scene)));
  rtcEnableGeometry(rtcGetGeometry(scene, id));
  rtcCommitScene(scene);
  EXPECT_EQ(statisticsOf(scene).numQuads, 6u * 256);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST(CompressionStatistics, CountMovingGeometry) {
  for (RTCCompression compression : {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF,
                                     RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CTILE}) {
    Device device;
    SurfaceSettings settings;
    Scene scene(device);
    settings.compression = compression;
    settings.fallbackFaces = true;
    addSurface(device, scene, quadCage(), settings);
    settings.timeSteps = 3;
    addSurface(device, scene, cubeCage(), settings);
    rtcCommitScene(scene);
    const RTCCompressionStatistics stats = statisticsOf(scene);
    EXPECT_EQ(stats.numQuads, 7u * 256);
    EXPECT_EQ(stats.numMovingQuads, 6u * 256);
    EXPECT_GT(stats.motionBytes, 0u);
    EXPECT_LT(stats.motionBytes, stats.leafBytes);
    EXPECT_GT(stats.maxVertexSpacing, 0);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  }
}

// The spacing follows the edges of each time step.
TEST(CompressionStatistics, ReportLargestSpacingOfAllTimeSteps) {
  Device device;
  const auto spacing = [&](unsigned timeSteps, const std::function<float(unsigned)>& scale) {
    SurfaceSettings settings;
    settings.compression = RTC_COMPRESSION_CVERT;
    settings.timeSteps = timeSteps;
    settings.motion = [&](const Vec& p, unsigned step) {
      return Vec{scale(step) * p[0], scale(step) * p[1], scale(step) * p[2]};
    };
    const SurfaceScene scene(device, cubeCage(), settings);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    return statisticsOf(scene).maxVertexSpacing;
  };
  const float still = spacing(1, [](unsigned) { return 1.0f; });
  EXPECT_GT(still, 0);
  for (unsigned large : {0u, 1u, 2u, 3u})
    EXPECT_EQ(spacing(4, [&](unsigned step) { return step == large ? 64.0f : 1.0f; }), 64 * still) << large;
}

// The geometry's diagonal limits the spacing, also if its square is not a normal float.
TEST(CompressionStatistics, SpacingFollowsTheScaleOfTinyGeometry) {
  Device device;
  const auto spacing = [&](const Cage& cage, int exponent) {
    Cage scaled = cage;
    for (Vec& p : scaled.positions)
      for (float& x : p) x = std::ldexp(x, exponent);
    SurfaceSettings settings;
    settings.compression = RTC_COMPRESSION_CVERT;
    const SurfaceScene scene(device, scaled, settings);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    return statisticsOf(scene).maxVertexSpacing;
  };
  const Cage one = quadCage();
  Cage two = one;
  for (const Vec& p : one.positions) two.positions.push_back({p[0] + 64, p[1], p[2]});
  two.addFace({4, 5, 6, 7});
  EXPECT_GT(spacing(two, 0), spacing(one, 0)) << "the diagonal has no effect, so nothing is tested";
  for (int exponent : {-30, -60, -70, -80}) EXPECT_EQ(spacing(two, exponent), std::ldexp(spacing(two, 0), exponent));
}

// The time steps of a mesh in mesh blocks share one lattice. Its spacing follows the median edge of all steps together:
// the edges of one step in four do not change it, and those of three do.
TEST(CompressionStatistics, ReportTheSpacingThatAllTimeStepsOfAMeshShare) {
  Device device;
  Random random(12);
  Diced sheet;
  sheet.add(17, 17, [](unsigned x, unsigned y) { return Vec{float(x), float(y), 0}; });
  const DicedMesh triangles = irregularTriangles(meshOf(sheet, QuadOrder::Rows, random), random);
  const auto spacing = [&](unsigned timeSteps, const std::function<float(unsigned)>& scale) {
    DicedMesh mesh = triangles;
    mesh.motion = [&](const Vec& p, unsigned step) { return Vec{scale(step) * p[0], scale(step) * p[1], float(step)}; };
    Scene scene(device);
    attach(scene, newMesh(device, mesh, RTC_COMPRESSION_CVERT, 0, timeSteps));
    rtcCommitScene(scene);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const RTCCompressionStatistics stats = programs::test::statisticsOf(scene);
    EXPECT_EQ(stats.numIrregularQuads, 256u);
    EXPECT_EQ(stats.numMovingQuads, timeSteps > 1 ? 256u : 0u);
    return stats.maxVertexSpacing;
  };
  const float still = spacing(1, [](unsigned) { return 1.0f; });
  EXPECT_GT(still, 0);
  for (unsigned other : {0u, 1u, 2u, 3u}) {
    EXPECT_EQ(spacing(4, [&](unsigned step) { return step == other ? 64.0f : 1.0f; }), still) << other;
    EXPECT_EQ(spacing(4, [&](unsigned step) { return step == other ? 1.0f : 64.0f; }), 64 * still) << other;
  }
}

// A peak next to the camera of maxPixelError. Lattices are chosen from a sample of the vertices, without the peak.
TEST(CompressionStatistics, SpacingIsAtMostThePixelErrorAtTheNearestVertex) {
  Device device;
  Random random(13);
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = RTC_COMPRESSION_CVERT;
  args.maxPixelError = 1;
  args.pixelSize = 0.001f;
  const Vec peak = {20, 20, 99};
  std::copy(peak.begin(), peak.end(), args.cameraPosition);
  args.cameraPosition[2] += 1;
  const auto spacing = [&](RTCGeometry geometry) {
    rtcSetGeometryCompression(geometry, &args);
    rtcCommitGeometry(geometry);
    Scene scene(device);
    attach(scene, geometry);
    rtcCommitScene(scene);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const RTCCompressionStatistics stats = programs::test::statisticsOf(scene);
    EXPECT_EQ(stats.numUncompressedQuads, 0u);
    return stats.maxVertexSpacing;
  };
  Diced sheet;
  sheet.add(65, 65, [&](unsigned x, unsigned y) {
    return x == 20 && y == 20 ? peak : Vec{float(x), float(y), 0.001f * ((x * 7 + y * 3) % 5)};
  });
  EXPECT_LE(spacing(newGrids(device, sheet)), 0.001f) << "grid";
  EXPECT_LE(spacing(newMesh(device, meshOf(sheet, QuadOrder::Rows, random))), 0.001f) << "quads";
  Diced large; // more triangles than the sample has
  large.add(300, 300, [](unsigned x, unsigned y) { return Vec{float(x), float(y), 0.001f * ((x * 7 + y * 3) % 5)}; });
  DicedMesh mesh = irregularTriangles(meshOf(large, QuadOrder::Rows, random), random);
  const unsigned first = unsigned(mesh.vertices.size());
  for (const Vec& p : {peak, Vec{21, 20, 98}, Vec{20, 21, 98}}) mesh.vertices.push_back(p);
  mesh.triangles.insert(mesh.triangles.begin() + 1, {first, first + 1, first + 2});
  EXPECT_LE(spacing(newMesh(device, mesh)), 0.001f) << "triangles";
  for (float rate : {8.0f, 64.0f}) {
    SurfaceSettings settings;
    settings.rate = rate;
    RTCGeometry cage = newSurface(device, quadCage(64), settings);
    rtcSetGeometryDisplacementFunction(cage, [](const RTCDisplacementFunctionNArguments* args) {
      for (unsigned i = 0; i < args->N; i++)
        if (std::hypot(args->P_x[i] - 20, args->P_y[i] - 20) < 6) args->P_z[i] = 99;
    });
    EXPECT_LE(spacing(cage), 0.001f) << "cage, rate " << rate;
  }
}

TEST(CompressionStatistics, CountFacesThatEmbreeDoesNotSupport) {
  const auto fan = [](unsigned faces, unsigned corners) { // around vertex 0
    Cage cage;
    cage.positions.push_back({0, 0, 0});
    for (unsigned i = 0; i < faces * (corners - 2); i++) {
      const double a = 2 * M_PI * i / double(faces * (corners - 2));
      cage.positions.push_back({float(std::cos(a)), float(std::sin(a)), 0});
    }
    const unsigned rim = unsigned(cage.positions.size()) - 1;
    for (unsigned f = 0; f < faces; f++) {
      cage.faces.push_back(corners);
      cage.indices.push_back(0);
      for (unsigned i = 0; i + 1 < corners; i++) cage.indices.push_back(1 + (f * (corners - 2) + i) % rim);
    }
    return cage;
  };
  Cage large = prismCage(20), tiny = sheetCage(4);
  Cage withHoles = large;
  withHoles.holes = {21, 0, 3};
  tiny.addFace({0, 1});
  struct Case {
    const char* name;
    Cage cage;
    size_t unsupported;
    bool hasOthers;
  } cases[] = {{"65 quads at a vertex", fan(65, 4), 0, true},
               {"1024 quads at a vertex", fan(1024, 4), 0, true},
               {"1025 quads at a vertex", fan(1025, 4), 1025, false},
               {"16 corners", prismCage(16), 0, true},
               {"20 corners, at which all quads are", large, 22, false},
               {"the same with holes", withHoles, 19, false},
               {"2 corners", tiny, 1, true}};
  for (const Case& c : cases)
    for (RTCCompression compression : {RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CLEAF}) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << kindName(compression));
      Device device;
      SurfaceSettings settings;
      settings.rate = 4;
      settings.compression = compression;
      Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
      RTCGeometry geometry = newSurface(device, c.cage, settings);
      rtcAttachGeometry(scene, geometry);
      rtcCommitScene(scene);
      const RTCCompressionStatistics stats = statisticsOf(scene);
      EXPECT_EQ(stats.numQuads + stats.numUncompressedQuads > 0, c.hasOthers);
      EXPECT_EQ(stats.numUnsupportedFaces, c.unsupported);
      EXPECT_EQ(device.errors, 0u) << "Embree does not report these faces, and programs rely on that: "
                                   << device.message;
      rtcReleaseGeometry(geometry);
    }
}

// Caches must fit into the second-level cache of a core.
TEST(CompressionStatistics, CachesPerThreadDependOnTheKindsOfBlocks) {
  const auto bytesOf = [](std::vector<RTCCompression> compressions, bool moves = false) {
    Device device;
    Scene scene(device, RTC_SCENE_FLAG_NONE);
    const Cage cage = prismCage(5);
    for (RTCCompression compression : compressions) {
      SurfaceSettings settings;
      settings.compression = compression;
      settings.timeSteps = moves ? 2 : 1;
      RTCGeometry geometry = newSurface(device, cage, settings);
      rtcAttachGeometry(scene, geometry);
      rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(scene);
    return statisticsOf(scene).cacheBytesPerThread;
  };
  const size_t vert = bytesOf({RTC_COMPRESSION_CVERT}), leaf = bytesOf({RTC_COMPRESSION_CLEAF});
  const size_t moving = bytesOf({RTC_COMPRESSION_CVERT}, true);
  EXPECT_EQ(bytesOf({}), 0u);
  EXPECT_EQ(bytesOf({RTC_COMPRESSION_NONE}), 0u);
  for (size_t bytes : {vert, leaf, moving}) {
    EXPECT_GT(bytes, size_t(1) << 16);
    EXPECT_LE(bytes, cacheLimit());
  }
  EXPECT_EQ(bytesOf({RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CVERT}), vert) << "geometries share the caches";
  EXPECT_EQ(bytesOf({RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CLEAF}), vert + leaf);
}

TEST(CompressionStatistics, MeshesWithoutGridsUseOneCache) {
  Device device;
  Random random(13);
  DicedMesh mesh; // triangles that share no vertices
  for (unsigned i = 0; i < 900; i++)
    mesh.vertices.push_back({float(random.uniform(-1, 1)), float(random.uniform(-1, 1)), float(random.uniform(-1, 1))});
  for (unsigned i = 0; i < 300; i++) mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  const MeshScene scene(device, mesh, RTC_COMPRESSION_CVERT);
  const RTCCompressionStatistics stats = programs::test::statisticsOf(scene);
  EXPECT_EQ(stats.numIrregularQuads, 150u);
  EXPECT_GT(stats.cacheBytesPerThread, size_t(1) << 16);
  EXPECT_LE(stats.cacheBytesPerThread, cacheLimit());
}

// The types of blocks decide, not statistics, which are optional in files.
TEST(CompressionStatistics, CachesPerThreadOfFilesWithoutCounts) {
  const auto bytesIn = [](Device& device, RTCGeometry geometry, bool hasCounts) {
    Scene scene(device);
    attach(scene, geometry);
    rtcCommitScene(scene);
    EXPECT_EQ(statisticsOf(scene).numBlocks > 0, hasCounts);
    return statisticsOf(scene).cacheBytesPerThread;
  };
  for (const Saveable& saveable : allSaveable()) {
    SCOPED_TRACE(saveable.name);
    const Folder folder;
    Device device;
    const std::string path = folder / "geometry";
    RTCGeometry geometry = saveable.make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, path.c_str())) << device.message;
    const size_t bytes = bytesIn(device, geometry, true);
    EXPECT_GT(bytes, size_t(1) << 16);
    FileBytes file(bytesOf(path));
    std::memset(file.record(0).counts, 0, sizeof(file.record(0).counts));
    file.fitChecksums();
    writeBytes(path, file.bytes);
    RTCGeometry loaded = loadGeometryFile(device, path.c_str());
    ASSERT_NE(loaded, nullptr) << device.message;
    EXPECT_EQ(bytesIn(device, loaded, false), bytes);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  }
}

// The frame level of a face is determined by its roughest sub-patch.
TEST(CompressionStatistics, ErrorBoundHoldsInEverySubPatch) {
  Device device;
  const Cage cage = prismCage(5);
  for (unsigned rough = 0; rough < 5; rough++) {
    Displacement displacement;
    displacement.amplitude = 0;
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.compression = RTC_COMPRESSION_CLEAF;
    settings.frameLevel = RTC_COMPRESSION_FRAME_LEVEL_AUTO;
    settings.maxError = 0.003f;
    settings.rate = 32;
    RTCGeometry geometry = newSurface(device, cage, settings);
    displacement.frequency = float(rough); // passes the value to the displacement function
    rtcSetGeometryDisplacementFunction(geometry, [](const RTCDisplacementFunctionNArguments* args) {
      const unsigned wanted = unsigned(((const Displacement*)args->geometryUserPtr)->frequency);
      for (unsigned i = 0; i < args->N; i++) {
        // corner k of an n-gon is at (2 (k%4) + 1/2, 2 (k/4) + 1/2)
        const float su = std::floor((args->u[i] - 0.25f) / 2), sv = std::floor((args->v[i] - 0.25f) / 2);
        if (args->primID < 2 && unsigned(su + 4 * sv) == wanted)
          args->P_z[i] += 0.02f * std::sin(8 * args->u[i]) * std::sin(6 * args->v[i]);
      }
    });
    rtcCommitGeometry(geometry);
    Scene scene(device);
    attach(scene, geometry);
    rtcCommitScene(scene);
    EXPECT_LE(statisticsOf(scene).maxLeafThickness, settings.maxError) << "sub-patch " << rough;
    EXPECT_LT(statisticsOf(scene).numBlocks, statisticsOf(scene).numQuads)
        << "the bound holds before blocks have one quad";
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  }
}

}} // namespace programs::test
