// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Lines on stderr about commits: compressed geometries, geometries that are not compressed with the reason, and memory.
 * */

#include "support/environment.h"
#include "support/irregular_mesh.h"
#include "support/memory.h"
#include "support/message_parts.h"

#include <gtest/gtest.h>

#include <memory>
#include <sstream>

namespace programs::test { namespace {

std::string commitTextOf(const std::string& config, const std::function<void(RTCDevice, RTCScene)>& add) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  {
    const Environment set("1,verbose");
    Device device(config);
    Scene scene(device);
    add(device, scene);
    rtcCommitScene(scene);
  }
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(testing::internal::GetCapturedStdout().find("compress"), std::string::npos)
      << "programs write pictures there";
  return text;
}

std::string commitLineOf(const std::string& config, const std::function<void(RTCDevice, RTCScene)>& add) {
  const std::string text = commitTextOf(config, add);
  const size_t begin = text.rfind("compression: "); // the commit of the scene comes last
  return begin == std::string::npos ? std::string() : text.substr(begin, text.find('\n', begin) - begin);
}

// Every type of geometry, static and moving, and static ones in Embree's narrower trees of SSE2.
TEST(CommitLine, ComparesWithEmbreesKernelOfTheSameType) {
  Random random(1);
  const std::pair<unsigned, const char*> cases[] = {{1, ""}, {1, "isa=sse2"}, {2, ""}, {3, ""}, {5, ""}};
  for (const auto& testCase : cases) {
    const unsigned timeSteps = testCase.first;
    const std::string isa = testCase.second;
    Diced grids = dicedSheet(4, 64);
    DicedMesh quads = meshOf(grids, QuadOrder::Rows, random), triangles = trianglesOf(quads);
    grids.motion = quads.motion = triangles.motion = [](const Vec& p, unsigned step) {
      return Vec{p[0], p[1], p[2] + 0.1f * float(step) * p[0]};
    };
    SurfaceSettings settings;
    settings.rate = 64;
    settings.timeSteps = timeSteps;
    const std::pair<const char*, std::function<RTCGeometry(RTCDevice)>> types[] = {
        {"1 subdivision surface as ", [&](RTCDevice device) { return newSurface(device, cubeCage(), settings); }},
        {"1 grid geometry as ",
         [&](RTCDevice device) { return newGrids(device, grids, RTC_COMPRESSION_INHERIT, 0, timeSteps); }},
        {"1 quad mesh as ",
         [&](RTCDevice device) { return newMesh(device, quads, RTC_COMPRESSION_INHERIT, 0, timeSteps); }},
        {"1 triangle mesh as ",
         [&](RTCDevice device) { return newMesh(device, triangles, RTC_COMPRESSION_INHERIT, 0, timeSteps); }}};
    for (const auto& type : types) {
      const bool areTiles = timeSteps <= 3 || std::string(type.first) != "1 grid geometry as ";
      const std::string name = type.first + std::string(areTiles ? "cTILE: " : "cVERT: ");
      const auto& make = type.second;
      SCOPED_TRACE(testing::Message() << name << timeSteps << " time steps " << isa);
      const std::string line =
          commitLineOf(isa, [&](RTCDevice device, RTCScene scene) { attach(scene, make(device)); });
      EXPECT_NE(line.find(name), std::string::npos) << line;
      EXPECT_EQ(line.find(", as cVERT about ") != std::string::npos, areTiles) << line;
      EXPECT_EQ(line.find("not compressed"), std::string::npos) << line;
      const size_t at = line.find("Embree would use about "), input = line.find("buffers that stay: ");
      ASSERT_NE(at, std::string::npos) << line;
      ASSERT_NE(input, std::string::npos) << line;
      Memory memory;
      Device device("subdiv_accel=bvh4.grid.eager" + (isa.empty() ? isa : "," + isa));
      rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
      Scene scene(device);
      attach(scene, make(device));
      const ssize_t before = memory.live;
      rtcCommitScene(scene);
      const double estimate = std::stod(line.substr(at + 23)), taken = double(memory.live - before) / (1 << 20);
      EXPECT_GT(estimate, 0.65 * taken) << line;
      EXPECT_LT(estimate, 1.35 * taken) << line;
      EXPECT_NEAR(std::stod(line.substr(input + 19)), double(before) / (1 << 20),
                  0.05 * double(before) / (1 << 20) + 0.02)
          << line;
    }
  }
}

// Their halves would need numbers of 33 bits. All quads have the same indices, because the stride is 0.
TEST(CommitLine, TooManyQuadsAreNotCompressed) {
  const std::string text = commitTextOf("", [](RTCDevice device, RTCScene) {
    const float vertices[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 0, 0};
    const unsigned indices[] = {0, 1, 2, 3};
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0, 12, 4);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, indices, 0, 0,
                               (size_t(1) << 31) + 1);
    rtcCommitGeometry(geometry);
    EXPECT_EQ(rtcGetDeviceError(device), RTC_ERROR_NONE);
    rtcReleaseGeometry(geometry);
  });
  EXPECT_TRUE(containsInOrder(text, {"not compressed", "2147483649 quads", "2147483648"}));
}

TEST(CommitLine, ListsUncompressedGeometriesAndReasons) {
  const std::string line = commitLineOf("", [](RTCDevice device, RTCScene scene) {
    Random random(1);
    DicedMesh scan;
    for (unsigned i = 0; i < 102; i++) {
      scan.vertices.push_back(
          {float(random.uniform(-1, 1)), float(random.uniform(-1, 1)), float(random.uniform(-1, 1))});
      if (i >= 2) scan.triangles.push_back({random.below(i), random.below(i), i});
    }
    attach(scene, newMesh(device, scan, RTC_COMPRESSION_INHERIT, 0, 2));
    attach(scene, newMesh(device, meshOf(dicedSheet(1, 8), QuadOrder::Rows, random)));
    attach(scene, newGrids(device, dicedSheet(10, 2)));
    attach(scene, newGrids(device, dicedSheet(2, 32)));
    SurfaceSettings settings;
    settings.compression = RTC_COMPRESSION_NONE;
    addSurface(device, scene, quadCage(), settings);
  });
  EXPECT_NE(line.find("compression: 1 grid geometry as cTILE: 4096 quads"), std::string::npos) << line;
  EXPECT_TRUE(containsInOrder(line, {"not compressed: 1 subdivision surface ", " ask ", " 100 grids ", " small ",
                                     " 64 quads that are too few to matter", " 100 triangles ", " few "}));
}

// Static and moving surfaces have a line each. If there is only one line, it lists the uncompressed geometries of both.
TEST(CommitLine, ListsEachUncompressedGeometryOnce) {
  Random random(1);
  const DicedMesh fixed = meshOf(dicedSheet(1, 8), QuadOrder::Rows, random),
                  moving = meshOf(dicedSheet(1, 4), QuadOrder::Rows, random);
  const std::string fixedText = " 64 quads ", movingText = " 16 quads ", sumText = " 80 quads ";
  for (unsigned sorts : {1u, 2u, 3u}) {
    const bool hasStatic = sorts & 1, hasMoving = sorts & 2;
    const std::string text = commitTextOf("", [&](RTCDevice device, RTCScene scene) {
      attach(scene, newMesh(device, fixed));
      attach(scene, newMesh(device, moving, RTC_COMPRESSION_INHERIT, 0, 2));
      if (hasStatic) attach(scene, newGrids(device, dicedSheet(2, 32)));
      if (hasMoving) attach(scene, newGrids(device, dicedSheet(2, 32), RTC_COMPRESSION_INHERIT, 0, 2));
    });
    SCOPED_TRACE(text);
    size_t numLines = 0;
    std::vector<size_t> linesOfFixed, linesOfMoving, linesOfBoth;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      if (line.find("Embree would use about") == std::string::npos) continue; // the commit of a geometry
      if (line.find(fixedText) != std::string::npos) linesOfFixed.push_back(numLines);
      if (line.find(movingText) != std::string::npos) linesOfMoving.push_back(numLines);
      if (line.find(sumText) != std::string::npos) linesOfBoth.push_back(numLines);
      numLines++;
    }
    EXPECT_EQ(numLines, size_t(hasStatic) + size_t(hasMoving));
    const size_t each = numLines == 2 ? 1 : 0;
    ASSERT_EQ(linesOfFixed.size(), each);
    ASSERT_EQ(linesOfMoving.size(), each);
    ASSERT_EQ(linesOfBoth.size(), 1 - each);
    if (each) { EXPECT_NE(linesOfFixed, linesOfMoving) << "the line of its own sort lists a geometry"; }
  }
}

TEST(CommitLine, ReportsCompressedGeometriesAndMemoryOfGrid) {
  const auto lineOf = [](const char* environment, const std::string& config, const SurfaceSettings& settings,
                         const Cage& cage = cubeCage()) {
    std::unique_ptr<Environment> set(environment ? new Environment(environment) : nullptr);
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    {
      Device device(config);
      const SurfaceScene scene(device, cage, settings);
    }
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_EQ(testing::internal::GetCapturedStdout().find("compression:"), std::string::npos)
        << "programs write pictures there";
    const size_t begin = text.find("compression: 1 subdivision surface");
    return begin == std::string::npos ? std::string() : text.substr(begin, text.find('\n', begin) - begin);
  };
  SurfaceSettings settings;
  settings.rate = 64;
  for (const char* environment : {"1,verbose", "verbose,cvert", "1,verbose=1", "verbose=0,verbose=2,1"}) {
    const std::string line = lineOf(environment, "", settings);
    const std::string kind = std::string(environment).find("cvert") == std::string::npos ? "cTILE" : "cVERT";
    EXPECT_NE(line.find("1 subdivision surface as " + kind + ": 24576 quads in 0."), std::string::npos) << line;
    EXPECT_EQ(line.find("not compressed"), std::string::npos) << line;
    /* the estimated memory of GRID matches its actual memory, except for the allocator's rounding */
    Memory memory;
    Device grid("subdiv_accel=bvh4.grid.eager");
    rtcSetDeviceMemoryMonitorFunction(grid, Memory::monitor, &memory);
    Scene scene(grid);
    addSurface(grid, scene, cubeCage(), settings);
    const ssize_t input = memory.live;
    rtcCommitScene(scene);
    const size_t at = line.find("about ");
    ASSERT_NE(at, std::string::npos) << line;
    const double mebibytes = std::stod(line.substr(at + 6)), taken = double(memory.live - input) / (1 << 20);
    EXPECT_GT(mebibytes, 0.85 * taken);
    EXPECT_LT(mebibytes, 1.1 * taken);
  }
  EXPECT_NE(lineOf(nullptr, "verbose=1,subdiv_accel=cbvh.voxel", settings).find("1 subdivision surface as cVOXEL"),
            std::string::npos);
  for (const char* environment : {"1", "1,verbose=0", "1,verbose,verbose=0"})
    EXPECT_EQ(lineOf(environment, "", settings), "") << environment;
  EXPECT_EQ(lineOf("verbose", "", settings), "");
  settings.edgeRates.assign(24, 8);
  settings.edgeRates[0] = 300;
  const std::string line = lineOf("voxel,verbose", "", settings);
  EXPECT_TRUE(containsInOrder(line, {"not compressed: 2400 quads ", "rates"}));
  /* a needle has no usable frame: it is left to GRID, or to cGRID if its sides have different rates */
  Cage needle = quadCage();
  for (Vec& p : needle.positions) p[1] *= 0x1p-20f;
  settings.edgeRates.assign(4, 8);
  const std::string refused = lineOf("voxel,verbose", "", settings, needle);
  EXPECT_TRUE(containsInOrder(refused, {"not compressed: 64 quads ", "frame"}));
  settings.edgeRates[0] = 16;
  const std::string kept = lineOf("voxel,verbose", "", settings, needle);
  EXPECT_EQ(kept.find("not compressed"), std::string::npos) << kept;
}

// At all time steps.
TEST(CommitLine, ReportsTheLargestMovementOfAVertex) {
  Random random(3);
  for (const char* config : {"cbvh_max_error=0.0015", "cbvh_max_error=0.01", "cbvh_max_error=0"})
    for (unsigned timeSteps : {1u, 3u}) {
      SCOPED_TRACE(testing::Message() << config << ", " << timeSteps << " time steps");
      DicedMesh mesh = jittered(meshOf(dicedSheet(2, 64), QuadOrder::Rows, random), random, 0.001);
      mesh.motion = [](const Vec& p, unsigned step) { return Vec{p[0], p[1], p[2] + 0.3f * float(step) * p[0]}; };
      const auto add = [&](RTCDevice device, RTCScene scene) {
        attach(scene, newMesh(device, mesh, RTC_COMPRESSION_INHERIT, 0, timeSteps));
      };
      const std::string line = commitLineOf(config, add);
      const size_t at = line.find("vertices move by up to ");
      const Environment set("1");
      const Device device(config);
      Scene scene(device);
      add(device, scene);
      rtcCommitScene(scene);
      const double moved = statisticsOf(scene).maxVertexDeviation;
      EXPECT_EQ(moved > 0, std::string(config) != "cbvh_max_error=0");
      ASSERT_EQ(at != std::string::npos, moved > 0) << line;
      if (moved > 0) { EXPECT_NEAR(std::stod(line.substr(at + 23)), moved, 0.005 * moved) << line; }
    }
}

TEST(InvalidQuads, AreReportedWithTheirReasons) {
  Random random(3);
  DicedMesh mesh = meshOf(dicedSheet(1, 32), QuadOrder::Rows, random);
  mesh.quads[100][2] = unsigned(mesh.vertices.size());
  mesh.vertices[mesh.quads[700][0]][0] = NAN;
  size_t invalid = 0;
  testing::internal::CaptureStderr();
  {
    const Device device("verbose=1");
    const MeshScene scene(device, mesh);
    invalid = statisticsOf(scene).numInvalidQuads;
  }
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_GT(invalid, 0u);
  EXPECT_TRUE(containsInOrder(lineWith(text, " 1024 quads"), {" 1 of 1024 quads", "index"})) << text;
  const std::string quads = " " + std::to_string(invalid) + " quads ";
  EXPECT_TRUE(containsInOrder(lineWith(text, quads), {quads, "finite"})) << text;
}

// At verbosity 0, in the line of the commit, and in the statistics.
TEST(InvalidQuads, AreNamedByTheirFirstPrimitive) {
  Random random(3);
  Diced grids = dicedSheet(4, 32);
  for (unsigned x : {7u, 9u}) grids.vertex(grids.grids[2], x, 5)[2] = INFINITY;
  DicedMesh quads = meshOf(dicedSheet(1, 32), QuadOrder::Rows, random), moving = quads;
  quads.quads[100][2] = unsigned(quads.vertices.size());
  quads.vertices[quads.quads[700][0]][0] = NAN;
  moving.motion = [](const Vec& p, unsigned step) { return step == 1 && p[0] == 0 && p[1] == 0 ? Vec{NAN, 0, 0} : p; };
  DicedMesh triangles = irregularTriangles(moving, random);
  triangles.vertices[triangles.triangles[33][1]][0] = NAN;
  Cage cage = sheetCage(8);
  cage.positions[31][2] = NAN;
  SurfaceSettings settings;
  settings.rate = 4;
  struct Case {
    const char* name;
    std::function<RTCGeometry(RTCDevice)> make;
    unsigned first;
  };
  size_t firstTriangle = 0;
  const auto isAt = [&](size_t t) {
    for (unsigned v : triangles.triangles[t])
      if (std::isnan(triangles.vertices[v][0])) return true;
    return false;
  };
  while (!isAt(firstTriangle)) firstTriangle++;
  const std::vector<Case> cases = {{"face", [&](RTCDevice device) { return newSurface(device, cage, settings); }, 10},
                                   {"grid", [&](RTCDevice device) { return newGrids(device, grids); }, 2},
                                   {"quad", [&](RTCDevice device) { return newMesh(device, quads); }, 100},
                                   {"triangle",
                                    [&](RTCDevice device) {
                                      triangles.motion = nullptr;
                                      return newMesh(device, triangles);
                                    },
                                    unsigned(firstTriangle)}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    RTCCompressionStatistics statistics;
    const std::string line = commitLineOf("", [&](RTCDevice device, RTCScene scene) {
      attach(scene, newGrids(device, dicedSheet(2, 32)));
      attach(scene, c.make(device));
      rtcCommitScene(scene);
      statistics = statisticsOf(scene);
    });
    EXPECT_GT(statistics.numInvalidQuads, 0u);
    EXPECT_EQ(statistics.firstInvalidGeomID, 1u);
    EXPECT_EQ(statistics.firstInvalidPrimID, c.first);
    EXPECT_TRUE(containsInOrder(line, {"left out: " + std::to_string(statistics.numInvalidQuads) + " quads", "finite",
                                       c.name + (" " + std::to_string(c.first) + " "), "geometry 1"}));
  }
}

// Input that has no effect is named once per change.
TEST(IgnoredInput, IsNamed) {
  Cage cage = sheetCage(4);
  cage.creases = {{0, 1}, {7, 13}, {3, 9}};
  cage.creaseWeights = {1, 2, NAN};
  testing::internal::CaptureStderr();
  {
    const Device device("");
    SurfaceSettings settings;
    settings.compression = RTC_COMPRESSION_CVERT;
    Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
    const RTCGeometry geometry = newSurface(device, cage, settings);
    attach(scene, geometry);
    rtcCommitScene(scene);
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
  }
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(containsInOrder(lineWith(text, "crease 1 "), {"vertices 7 and 13", "edge", " 1 other:"})) << text;
  EXPECT_NE(lineWith(text, "edge crease weight 2 "), "") << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
}

// At verbosity 0, because users of a program do not learn otherwise why the cap of a cylinder is missing.
TEST(UnsupportedFaces, ArePrintedOncePerChange) {
  testing::internal::CaptureStderr();
  {
    const Device device("");
    SurfaceSettings settings;
    settings.compression = RTC_COMPRESSION_CVERT;
    settings.rate = 2;
    Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
    const RTCGeometry geometry = newSurface(device, prismCage(20), settings);
    attach(scene, geometry);
    for (int i = 0; i < 3; i++) rtcCommitScene(scene);
  }
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(containsInOrder(text, {"geometry 0", " 22 faces", "face 0,", " 16 ", " 1024 "})) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
}

// Also if lines about commits are off.
TEST(CoarseLattice, IsReportedOnce) {
  Random random(2);
  const DicedMesh mesh = meshOf(dicedSheet(2, 32), QuadOrder::Rows, random); // edges of 1/32
  const DicedMesh irregular = irregularTriangles(mesh, random);
  const auto reported = [&](const char* config, bool isRegular = true) {
    testing::internal::CaptureStderr();
    const Device device(config);
    const MeshScene scene(device, isRegular ? mesh : irregular);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(reported("cbvh_max_error=0.001"), "");
  const std::string text = reported("cbvh_max_error=0.05");
  EXPECT_TRUE(containsInOrder(lineWith(text, "max_error"), {"max_error", " 0.03125", " edge"})) << text;
  EXPECT_EQ(reported("cbvh_max_error=0.05"), "") << "once";
  EXPECT_NE(lineWith(reported("cbvh_max_error=0.05,verbose=1"), "max_error"), "");
  EXPECT_NE(lineWith(reported("cbvh_max_error=0.05,verbose=1", false), "max_error"), "");
}

// Integers remain integers with an error of 1, so that nothing is lost.
TEST(CoarseLattice, IsNotReportedIfNoVertexMoves) {
  Random random(3);
  DicedMesh mesh = meshOf(dicedSheet(2, 32), QuadOrder::Rows, random);
  for (Vec& p : mesh.vertices) {
    for (float& x : p) x = std::round(32 * x);
    p[2] = 0;
  }
  const auto reported = [&](const DicedMesh& stored, bool moves = false) {
    testing::internal::CaptureStderr();
    {
      const Device device("cbvh_max_error=1,verbose=1");
      const RTCCompressionStatistics statistics = statisticsOf(MeshScene(device, stored));
      EXPECT_EQ(statistics.maxVertexSpacing, 1.0f);
      EXPECT_EQ(statistics.maxVertexDeviation > 0, moves);
    }
    return lineWith(testing::internal::GetCapturedStderr(), "median edge");
  };
  const DicedMesh irregular = irregularTriangles(mesh, random);
  EXPECT_EQ(reported(mesh), "");
  EXPECT_EQ(reported(irregular), "");
  DicedMesh moved = mesh;
  for (Vec& p : moved.vertices) p[2] = float(random.uniform(0, 0.5));
  EXPECT_NE(reported(moved, true), "");
}

// Mesh blocks have a finer lattice if the requested one would flip most triangles.
TEST(CoarseLattice, IsTheOneOfTheMeshBlocks) {
  Random random(2);
  const DicedMesh mesh = irregularTriangles(meshOf(dicedSheet(2, 32), QuadOrder::Rows, random), random);
  for (const char* error : {"0.05", "0.1", "0.5", "2"}) {
    SCOPED_TRACE(error);
    testing::internal::CaptureStderr();
    float spacing;
    {
      const Device device(("verbose=1,cbvh_max_error=" + std::string(error)).c_str());
      spacing = statisticsOf(MeshScene(device, mesh)).maxVertexSpacing;
    }
    const std::string line = lineWith(testing::internal::GetCapturedStderr(), "max_error");
    const size_t number = line.find_first_of("0123456789");
    if (number != std::string::npos) EXPECT_EQ(std::stof(line.substr(number)), spacing);
    else EXPECT_LT(spacing, 0.01f);
  }
}

}} // namespace programs::test
