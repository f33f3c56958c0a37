// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "support/mesh_bytes.h"
#include "support/message_parts.h"
#include "support/read_mesh.h"

#include <cmath>
#include <filesystem>
#include <fstream>

namespace programs::test { namespace {

PolygonMesh gltfMesh(const std::string& bytes, std::string* warnings = nullptr) {
  return meshOf("test.gltf", bytes, warnings);
}

const Corners twoTriangles = {0, 1, 2, 0, 2, 3};

std::string squareWith(const std::string& nodes) {
  return gltf(squareBuffer(), squareViews, squareAccessors, squareMesh + nodes);
}

TEST(GltfReader, BufferInBase64InAGlbAndInAFile) {
  const std::string rest = squareMesh + oneMesh;
  const std::string embedded = gltf(squareBuffer(), squareViews, squareAccessors, rest);
  const std::string chunk = glb(gltf(squareBuffer(), squareViews, squareAccessors, rest, "none"), squareBuffer());
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("gltf_" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  std::ofstream(folder / "a b.bin", std::ios::binary) << squareBuffer();
  std::ofstream(folder / "a.gltf") << gltf(squareBuffer(), squareViews, squareAccessors, rest, "a%20b.bin");
  std::string warnings;
  for (const PolygonMesh& mesh : {gltfMesh(embedded), meshOf("test.glb", chunk), meshOf("a pipe", chunk),
                                  readMesh((folder / "a.gltf").string(), warnings)}) {
    EXPECT_EQ(mesh.faceIndices, twoTriangles);
    expectPosition(mesh, 2, 1, 1, 0);
    EXPECT_EQ(mesh.up, "y");
  }
  std::filesystem::remove_all(folder);
}

TEST(GltfReader, NormalizedAndOtherIntegersWithAStride) {
  struct Case {
    int type;
    std::string buffer; // two vertices of 3, the first ones the largest and least values
    bool isNormalized;
    double largest, least;
  };
  const auto padded = [](auto a, auto b) {
    using T = decltype(a);
    const std::string one = bytesOf(std::vector<T>{a, b, 0, 0});
    return one + one + one;
  };
  const Case cases[] = {
      {5120, padded(int8_t(127), int8_t(-128)), true, 1, -1},
      {5121, padded(uint8_t(255), uint8_t(51)), true, 1, 0.2},
      {5122, padded(int16_t(32767), int16_t(-32768)), true, 1, -1},
      {5123, padded(uint16_t(65535), uint16_t(13107)), true, 1, 0.2},
      {5122, padded(int16_t(32767), int16_t(-32768)), false, 32767, -32768},
      {5121, padded(uint8_t(255), uint8_t(51)), false, 255, 51},
      {5126, padded(2.5f, -7.0f), false, 2.5, -7},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.type);
    const std::string size = std::to_string(c.buffer.size());
    const PolygonMesh mesh = gltfMesh(
        gltf(c.buffer,
             "{\"buffer\":0,\"byteLength\":" + size + ",\"byteStride\":" + std::to_string(c.buffer.size() / 3) + "}",
             "{\"bufferView\":0,\"count\":3,\"type\":\"VEC3\",\"componentType\":" + std::to_string(c.type) +
                 (c.isNormalized ? ",\"normalized\":true}" : "}"),
             "\"extensionsRequired\":[\"KHR_mesh_quantization\"],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]," +
                 oneMesh));
    EXPECT_EQ(mesh.faceIndices, (Corners{0, 1, 2})) << "without indices";
    expectPosition(mesh, 2, c.largest, c.least, 0);
  }
}

TEST(GltfReader, SparseValuesReplaceOthers) {
  const std::string buffer =
      squareBuffer() + bytesOf(std::vector<uint8_t>{1, 3, 0, 0}) + bytesOf(std::vector<float>{5, 6, 7, 8, 9, 10});
  const std::string views = squareViews + R"(,{"buffer":0,"byteOffset":60,"byteLength":2},)"
                                          R"({"buffer":0,"byteOffset":64,"byteLength":24})";
  const std::string sparse =
      R"("sparse":{"count":2,"indices":{"bufferView":2,"componentType":5121},)"
      R"("values":{"bufferView":3}}},{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"})";
  for (const char* base : {"\"bufferView\":0,", ""}) {
    const PolygonMesh mesh = gltfMesh(
        gltf(buffer, views, std::string("{") + base + R"("componentType":5126,"count":4,"type":"VEC3",)" + sparse,
             squareMesh + oneMesh));
    expectPosition(mesh, 1, 5, 6, 7);
    expectPosition(mesh, 3, 8, 9, 10);
    expectPosition(mesh, 2, *base ? 1 : 0, *base ? 1 : 0, 0); // zero without a buffer view
  }
}

TEST(GltfReader, StripsAndFansHaveTheOrientationOfTriangles) {
  const auto withMode = [](int mode, const std::string& indices) {
    std::string warnings;
    return gltfMesh(gltf(squareBuffer() + indices,
                         squareViews + R"(,{"buffer":0,"byteOffset":60,"byteLength":)" +
                             std::to_string(indices.size()) + "}",
                         squareAccessors + R"(,{"bufferView":2,"componentType":5121,"count":)" +
                             std::to_string(indices.size()) + R"(,"type":"SCALAR"})",
                         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":0},)"
                         R"({"attributes":{"POSITION":0},"indices":2,"mode":)" +
                             std::to_string(mode) + "}]}]," + oneMesh),
                    &warnings)
        .faceIndices;
  };
  EXPECT_EQ(withMode(4, std::string("\0\1\2\0\2\3", 6)), twoTriangles);
  EXPECT_EQ(withMode(5, std::string("\0\1\3\2", 4)), (Corners{0, 1, 3, 3, 1, 2}));
  EXPECT_EQ(withMode(6, std::string("\0\1\2\3", 4)), twoTriangles);
}

TEST(GltfReader, MatricesOfNodesAndMirroredOnes) {
  const PolygonMesh mesh = gltfMesh(squareWith(
      R"("nodes":[{"children":[1,2],"translation":[10,0,0],"rotation":[0,0,0.7071067811865476,0.7071067811865476]},)"
      R"({"mesh":0,"scale":[2,3,4]},{"mesh":0,"matrix":[-1,0,0,0,0,1,0,0,0,0,1,0,0,0,5,1]}],)"
      R"("scenes":[{"nodes":[0]}])"));
  ASSERT_EQ(mesh.positions.size(), 8u);
  expectPosition(mesh, 1, 10, 2, 0);
  expectPosition(mesh, 3, 7, 0, 0);
  expectPosition(mesh, 5, 10, -1, 5);
  EXPECT_EQ(mesh.faceIndices, (Corners{0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6})) << "the mirrored copy is turned";
}

TEST(GltfReader, OnlyTheDefaultSceneIsReadWithAWarning) {
  std::string warnings;
  const std::string scenes = R"("nodes":[{"mesh":0},{"mesh":0,"translation":[5,0,0]},{"name":"light"}],)"
                             R"("scenes":[{"nodes":[0]},{"nodes":[2,1]}],"scene":1)";
  const PolygonMesh mesh = gltfMesh(squareWith(scenes), &warnings);
  EXPECT_EQ(mesh.numFaces(), 2u);
  expectPosition(mesh, 0, 5, 0, 0);
  EXPECT_TRUE(containsInOrder(warnings, {"test.gltf: ", "scene 1 of 2"}));
  EXPECT_EQ(gltfMesh(squareWith(R"("nodes":[{"mesh":0},{"mesh":0}])")).numFaces(), 4u) << "no scene: all nodes";
  EXPECT_EQ(gltfMesh(squareWith(R"("scene":0)")).numFaces(), 2u) << "no nodes: all meshes";
}

TEST(GltfReader, PrimitivesOfOneMeshShareVertices) {
  const std::string mesh = R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1},)"
                           R"({"attributes":{"POSITION":0},"indices":1},{"attributes":{"POSITION":0},"mode":1}]}],)";
  std::string warnings;
  const PolygonMesh read = gltfMesh(gltf(squareBuffer(), squareViews, squareAccessors, mesh + oneMesh), &warnings);
  EXPECT_EQ(read.positions.size(), 4u);
  EXPECT_EQ(read.numFaces(), 4u);
  EXPECT_TRUE(containsInOrder(warnings, {"test.gltf: ", "left out", "1 "}));
}

TEST(GltfReader, MorphTargetsHaveTheWeightsOfTheFile) {
  const std::string mesh = R"("meshes":[{"weights":[0.5],"primitives":[{"attributes":{"POSITION":0},"indices":1,)"
                           R"("targets":[{"POSITION":0}]}]}],)";
  const auto read = [&](const std::string& nodes) {
    return gltfMesh(gltf(squareBuffer(), squareViews, squareAccessors, mesh + nodes));
  };
  expectPosition(read(oneMesh), 2, 1.5, 1.5, 0);
  expectPosition(read(R"("nodes":[{"mesh":0,"weights":[3]}])"), 2, 4, 4, 0);
}

TEST(GltfReader, SkinsFollowTheirJointsAndNotTheirNode) {
  std::string joints, weights;
  for (int i = 0; i < 4; i++) {
    joints += bytesOf(std::vector<uint8_t>{0, 1, 0, 0});
    weights += bytesOf(std::vector<float>{i < 2 ? 1.0f : 0.5f, i < 2 ? 0.0f : 0.5f, 0, 0});
  }
  const std::string buffer = squareBuffer() + joints + weights;
  const std::string views = squareViews + R"(,{"buffer":0,"byteOffset":60,"byteLength":16},)"
                                          R"({"buffer":0,"byteOffset":76,"byteLength":64})";
  const std::string accessors = squareAccessors + R"(,{"bufferView":2,"componentType":5121,"count":4,"type":"VEC4"},)"
                                                  R"({"bufferView":3,"componentType":5126,"count":4,"type":"VEC4"})";
  const PolygonMesh mesh = gltfMesh(
      gltf(buffer, views, accessors,
           R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3},"indices":1}]}],)"
           R"("skins":[{"joints":[1,2]}],"nodes":[{"mesh":0,"skin":0,"translation":[100,0,0]},{"translation":[0,0,1]},)"
           R"({"translation":[0,4,1]}],"scenes":[{"nodes":[0,1,2]}])"));
  expectPosition(mesh, 1, 1, 0, 1);
  expectPosition(mesh, 2, 1, 3, 1);
}

TEST(GltfReader, RejectsDamagedFilesWithTheirPlace) {
  struct Case {
    std::string bytes;
    std::vector<std::string> parts;
  };
  const auto document = [](const std::string& accessors, const std::string& rest = squareMesh + oneMesh) {
    return gltf(squareBuffer(), squareViews, accessors, rest);
  };
  const std::string indices = R"(,{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"})";
  const std::string whole =
      glb(gltf(squareBuffer(), squareViews, squareAccessors, squareMesh + oneMesh, "none"), squareBuffer());
  const Case cases[] = {
      {"{", {"byte 2", "JSON"}},
      {"[]", {"'asset'"}},
      {R"({"asset":{"version":"1.0"}})", {"'1.0'", "2.0"}},
      {R"({"asset":{"version":"2.0"}})", {"no triangles"}},
      {document(squareAccessors, R"("extensionsRequired":["KHR_draco_mesh_compression"],)" + squareMesh + oneMesh),
       {"'KHR_draco_mesh_compression'"}},
      {document(squareAccessors, R"("extensionsRequired":["EXT_meshopt_compression"],)" + squareMesh + oneMesh),
       {"'EXT_meshopt_compression'"}},
      {document(R"({"bufferView":0,"componentType":5126,"count":5,"type":"VEC3"})" + indices),
       {"accessors[0]", " 5 elements", " 48 bytes"}},
      {document(R"({"bufferView":0,"componentType":5126,"count":4000000000,"type":"VEC3"})" + indices),
       {"accessors[0]", " 4000000000 elements"}},
      {document(R"({"componentType":5126,"count":4000000000,"type":"VEC3","sparse":{}})" + indices),
       {"accessors[0]", " 4000000000 elements"}},
      {document(R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC2"})" + indices),
       {"accessors[0]", "'VEC2'", "VEC3"}},
      {document(R"({"bufferView":0,"componentType":7,"count":4,"type":"VEC3"})" + indices), {"accessors[0]", " 7"}},
      {document(R"({"bufferView":7,"componentType":5126,"count":4,"type":"VEC3"})" + indices), {"bufferViews", " 7"}},
      {document(R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})" + indices),
       {"indices", "index 3", " 3 vertices"}},
      {document(squareAccessors, squareMesh + R"("nodes":[{"mesh":0,"children":[1]},{"children":[0]}])"), {"children"}},
      {document(squareAccessors, squareMesh + R"("nodes":[{"children":[2]},{"children":[2]},{"mesh":0}])"),
       {"nodes[1].children", "node 2"}},
      {document(squareAccessors, squareMesh + R"("nodes":[{"mesh":3}])"), {"meshes", " 3"}},
      {document(squareAccessors, squareMesh + R"("nodes":[{"mesh":0,"scale":[1,2]}])"),
       {"nodes[0].scale", " 2 numbers"}},
      {document(squareAccessors, squareMesh + R"("nodes":[{"mesh":0,"scale":[1e300,1,1]}])"), {"POSITION", "vertex 1"}},
      {document(squareAccessors, squareMesh + R"("nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{}}}])"),
       {"nodes[0]", "'EXT_mesh_gpu_instancing'"}},
      {gltf(squareBuffer(), squareViews, squareAccessors, squareMesh + oneMesh, "https://host/a.bin"),
       {"'https://host/a.bin'"}},
      {gltf(squareBuffer(), squareViews, squareAccessors, squareMesh + oneMesh, "missing.bin"),
       {"buffers[0].uri", "missing.bin"}},
      {gltf(squareBuffer(), squareViews, squareAccessors, squareMesh + oneMesh, "data:;base64,AA!A"),
       {"buffers[0].uri", "base64"}},
      {gltf(squareBuffer(), squareViews, squareAccessors, squareMesh + oneMesh, "data:;base64,AAAA"),
       {"buffers[0]", " 3 bytes", " 60"}},
      {gltf(squareBuffer(), squareViews, squareAccessors, squareMesh + oneMesh, "none"), {"buffers[0]", "no data"}},
      {whole.substr(0, whole.size() - 1), {"ends at byte " + std::to_string(whole.size() - 1)}},
      {whole.substr(0, 10), {"ends at byte 10"}},
      {whole + "a", {std::to_string(whole.size()) + " bytes"}},
      {"glTF" + bytesOf(uint32_t(1)) + bytesOf(uint32_t(12)), {"version 1"}},
  };
  for (const Case& c : cases) {
    const std::string error = meshError("test.gltf", c.bytes);
    EXPECT_TRUE(containsInOrder(error, c.parts)) << c.bytes;
  }
}

}} // namespace programs::test
