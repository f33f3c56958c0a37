// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "support/mesh_bytes.h"
#include "support/message_parts.h"
#include "support/read_mesh.h"

#include <cmath>

namespace programs::test { namespace {

PolygonMesh stl(const std::string& bytes) { return meshOf("test.stl", bytes); }

TEST(StlReader, MergesExactlyEqualPositionsOnly) {
  const float next = std::nextafter(1e-6f, 1.0f), zero = -0.0f;
  const PolygonMesh mesh = stl(binaryStl({0, 0, 0, 1e-6f, 0, 0, 0, 1e-6f, 0,      // edges of a millionth
                                          next, 0, 0, 1e-6f, 0, 0, zero, 0, 0})); // one vertex is a float away
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.faceIndices, (Corners{0, 1, 2, 3, 1, 0}));
}

TEST(StlReader, KeepsTrianglesWithoutArea) {
  const PolygonMesh mesh = stl(binaryStl({0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0}));
  EXPECT_EQ(mesh.faceIndices, (Corners{0, 0, 1, 0, 1, 2}));
}

TEST(StlReader, BinaryFilesMayBeginWithSolid) {
  const std::vector<float> triangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  for (const char* header : {"solid", "solid part\nfacet normal 0 0 1", "SOLID \n", "COLOR=abcd", "solid a\nb"}) {
    SCOPED_TRACE(header);
    EXPECT_EQ(stl(binaryStl(triangle, header)).faceIndices, (Corners{0, 1, 2}));
  }
}

TEST(StlReader, TextWithSeveralSolidsAndDoubles) {
  for (const char* lineEnd : {"\n", "\r\n"}) {
    const std::string text = "solid first part\n" + stlFacet(square[0], square[1], square[2]) +
                             "endsolid first part\n" + "\nSOLID\n" + stlFacet("0 0 0", "1 1 0", "1e6 0.000000001 -0") +
                             "endsolid\n" + "solid empty\nendsolid empty\n";
    std::string lines;
    for (const char c : text) lines += c == '\n' ? std::string(lineEnd) : std::string(1, c);
    const PolygonMesh mesh = stl(lines);
    EXPECT_EQ(mesh.faceIndices, (Corners{0, 1, 2, 0, 2, 3}));
    EXPECT_EQ(mesh.positions[3].y, 1e-9);
  }
}

TEST(StlReader, RejectsDamagedFilesWithTheirPlace) {
  struct Case {
    std::string bytes;
    std::vector<std::string> parts;
  };
  const std::string binary = binaryStl({0, 0, 0, 1, 0, 0, 0, 1, 0}), facet = stlFacet(square[0], square[1], square[2]);
  const Case cases[] = {
      {"", {" 0 bytes", "'solid'"}},
      {"abc", {" 3 bytes", "'solid'"}},
      {binary.substr(0, binary.size() - 1), {" 133 bytes", " 134 ", " 1 triangles"}},
      {binary + "a", {" 135 bytes", " 134 ", " 1 triangles"}},
      {std::string(80, 'a') + bytesOf(~0u), {" 84 bytes", "4294967295"}},
      {binaryStl({}), {"no triangles"}},
      {binaryStl({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, NAN, 0, 0, 1, 0}), {"triangle 1", "nan"}},
      {binaryStl({0, 0, 0, 1, 0, 0, 0, -INFINITY, 0}), {"triangle 0", "-inf"}},
      {"solid a\nendsolid a\n", {"no triangles"}},
      {"solid a\n" + facet, {"ends within a solid", "'endsolid'"}},
      {"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", {"ends within a triangle", "'vertex'"}},
      {"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", {":4: ", "''"}},
      {"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\n", {":4: ", "'nan'"}},
      {"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0 1\n", {":4: ", "'1'"}},
      {"solid a\n" + facet + "polygon\n", {":9: ", "'polygon'", "'facet normal'"}},
      {"solid a\n" + facet + "endsolid a\nmore\n", {":10: ", "'more'", "'solid'"}},
  };
  for (const Case& c : cases) {
    const std::string error = meshError("test.stl", c.bytes);
    EXPECT_TRUE(containsInOrder(error, c.parts)) << c.bytes;
  }
}

}} // namespace programs::test
