// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "support/mesh_bytes.h"
#include "support/message_parts.h"
#include "support/read_mesh.h"

namespace programs::test { namespace {

const std::string vertices4 = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const std::string listOfFaces = "element face 1\nproperty list uchar int vertex_indices\n";
const std::string squareLines = square[0] + "\n" + square[1] + "\n" + square[2] + "\n" + square[3] + "\n";

PolygonMesh ply(const std::string& bytes) { return meshOf("test.ply", bytes); }

TEST(PlyReader, TextWithEveryNameOfATypeAndEveryLineEnd) {
  for (const char* lineEnd : {"\n", "\r\n", "\r"})
    for (const char* index :
         {"char", "int8", "uchar", "uint8", "short", "int16", "ushort", "uint16", "int", "int32", "uint", "uint32"})
      for (const char* real : {"float", "float32", "double", "float64", "int", "short"}) {
        SCOPED_TRACE(testing::Message() << index << ", " << real);
        const std::string type(real);
        const std::string text =
            plyHeader("ascii", "obj_info by hand\nelement vertex 4\nproperty " + type + " x\nproperty " + type +
                                   " y\nproperty " + type + " z\nelement face 1\nproperty list " + index + " " + index +
                                   " vertex_indices\n") +
            squareLines + "\n4 0 1 2 3\n\n";
        std::string lines;
        for (const char c : text) lines += c == '\n' ? std::string(lineEnd) : std::string(1, c);
        const PolygonMesh mesh = ply(lines);
        EXPECT_EQ(mesh.faceSizes, Corners{4});
        EXPECT_EQ(mesh.faceIndices, (Corners{0, 1, 2, 3}));
        expectPosition(mesh, 2, 1, 1, 0);
        EXPECT_EQ(mesh.comments, " by hand\n");
      }
}

TEST(PlyReader, BinaryOfBothByteOrdersKeepsPolygonsAndDoubles) {
  for (const bool isBigEndian : {false, true}) {
    const PolygonMesh mesh = ply(binaryPly(isBigEndian));
    EXPECT_EQ(mesh.faceSizes, (Corners{5, 3}));
    EXPECT_EQ(mesh.faceIndices, (Corners{0, 1, 2, 3, 4, 5, 4, 3}));
    ASSERT_EQ(mesh.positions.size(), 6u);
    EXPECT_EQ(mesh.positions[5].x, 1e6 + 5e-9) << "no rounding to floats";
    expectPosition(mesh, 5, 1e6 + 5e-9, -5, 5);
  }
}

TEST(PlyReader, BinaryDataMayBeginWithALineFeed) {
  for (const char* lineEnd : {"\n", "\r", "\r\n"}) {
    std::string header;
    for (const char c : plyHeader("binary_little_endian", "element face 1\nproperty list uchar uchar vertex_indices\n"
                                                          "element vertex 11\nproperty char x\nproperty char y\n"
                                                          "property char z\n"))
      header += c == '\n' ? std::string(lineEnd) : std::string(1, c);
    const PolygonMesh mesh = ply(header + "\n\1\2\3\4\5\6\7\10\11\12" + std::string(33, '\1')); // 10 corners
    EXPECT_EQ(mesh.faceSizes, Corners{10});
    EXPECT_EQ(mesh.faceIndices.back(), 10u);
  }
}

TEST(PlyReader, FacesOf300CornersAreWhole) {
  std::string text = plyHeader("ascii", "element vertex 300\nproperty float x\nproperty float y\nproperty float z\n"
                                        "element face 1\nproperty list ushort int vertex_indices\n");
  for (int i = 0; i < 300; i++) text += std::to_string(i) + " " + std::to_string(i * i) + " 0\n";
  text += "300";
  for (int i = 0; i < 300; i++) text += " " + std::to_string(i);
  const PolygonMesh mesh = ply(text + "\n");
  EXPECT_EQ(mesh.faceSizes, Corners{300});
  EXPECT_EQ(mesh.faceIndices.back(), 299u);
}

TEST(PlyReader, StripsBecomeTrianglesOfOneOrientation) {
  const std::string text =
      plyHeader("ascii", vertices4 + "element tristrips 1\nproperty list int int vertex_indices\n") + squareLines +
      "14 0 1 3 2 -1 3 2 1 0 -1 0 1 1 2\n";
  const PolygonMesh mesh = ply(text);
  EXPECT_EQ(mesh.faceSizes, (Corners{3, 3, 3, 3}));
  EXPECT_EQ(mesh.faceIndices, (Corners{0, 1, 3, 3, 1, 2, 3, 2, 1, 1, 2, 0}))
      << "0 1 1 and 1 1 2 only connect parts of a strip";
}

TEST(PlyReader, RejectsDamagedFilesWithTheirPlace) {
  struct Case {
    std::string bytes;
    std::vector<std::string> parts;
  };
  const std::string header = plyHeader("ascii", vertices4 + listOfFaces), binary = binaryPly(false);
  const std::string huge = "element vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n";
  const Case cases[] = {
      {"obj\n", {":1: ", "'obj'", "'ply'"}},
      {"ply\nformat ascii 2.0\n", {":2: ", "ascii 2.0"}},
      {"ply\nformat ascii 1.0\nelement vertex -1\n", {":3: ", "'vertex'", "'-1'"}},
      {"ply\nformat ascii 1.0\nelement vertex 4\nproperty half x\n", {":4: ", "'half'"}},
      {"ply\nformat ascii 1.0\nelement vertex 4\n", {":4: ", "ends within the header"}},
      {plyHeader("ascii", vertices4) + squareLines, {"'face'", " 4 vertices"}},
      {plyHeader("ascii", vertices4 + "element face 1\nproperty int a\n") + squareLines + "1\n", {"vertex_indices"}},
      {plyHeader("ascii", vertices4 + "element face 0\nproperty list uchar int vertex_index\n") + squareLines,
       {"no faces"}},
      {plyHeader("ascii", vertices4 + "element \1\xff 1\nproperty int a\n" + listOfFaces) + squareLines,
       {"ends before ?? 0"}},
      {header + squareLines, {"ends before face 0", " 1 "}},
      {header + squareLines + "4 0 1 2\n", {":14: ", "face 0", "too few"}},
      {header + squareLines + "3 0 1 2 3\n", {":14: ", "face 0", "'3'"}},
      {header + squareLines + "2 0 1\n", {":14: ", "face 0", " 2 vertices"}},
      {header + squareLines + "3 0 1 4\n", {"face 0", "index 4", " 4 vertices"}},
      {header + squareLines + "3 0 1 -2\n", {":14: ", "index -2"}},
      {header + squareLines + "3 0 1 1.5\n", {":14: ", "'1.5'", "integer"}},
      {header + squareLines + "3 0 1 2\n3 1 2 3\n", {":15: ", "'3'", "end of the file"}},
      {header + "0 0 0\n1 nan 0\n", {":11: ", "vertex 1", "nan"}},
      {header + "0 0 0\n1 1e60 0\n", {":11: ", "vertex 1", "1e+60", "32 bits"}},
      {header + "0 0 0\n1 x 0\n", {":11: ", "vertex 1", "'x'"}},
      {binary.substr(0, binary.size() - 1), {"ends within vertex 5", " 6 "}},
      {binary + "abc", {"data follows", "byte " + std::to_string(binary.size())}},
      {plyHeader("ascii", huge + listOfFaces), {"ends before vertex 0", "4000000000"}},
      {plyHeader("binary_little_endian", huge + listOfFaces) + "abcd", {"ends within vertex 0", "4000000000"}},
      {plyHeader("binary_little_endian", "element vertex 99999999999\nproperty float x\n" + listOfFaces),
       {"99999999999"}},
      {plyHeader("binary_little_endian", listOfFaces + vertices4) + bytesOf(uint8_t(255)), {"ends within face 0"}},
  };
  for (const Case& c : cases) {
    const std::string error = meshError("test.ply", c.bytes);
    EXPECT_TRUE(containsInOrder(error, c.parts)) << c.bytes;
  }
}

}} // namespace programs::test
