// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "meshes/mesh_file.h"
#include "meshes/polygon_triangles.h"
#include "support/mesh_bytes.h"
#include "support/message_parts.h"
#include "support/random.h"
#include "support/read_mesh.h"

#include <cmath>

namespace programs::test { namespace {

TEST(MeshFiles, FormatsByTheFirstBytesOrTheExtension) {
  const std::string ply = binaryPly(false), stl = binaryStl({0, 0, 0, 1, 0, 0, 0, 1, 0});
  const std::string text = "solid a\n" + stlFacet(square[0], square[1], square[2]) + "endsolid a\n";
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  EXPECT_EQ(meshOf("/dev/fd/63", ply).numFaces(), 2u);
  EXPECT_EQ(meshOf("a.PLY", ply).numFaces(), 2u);
  EXPECT_EQ(meshOf("a.Stl", stl).numFaces(), 1u);
  EXPECT_EQ(meshOf("/dev/fd/63", text).numFaces(), 1u);
  EXPECT_EQ(meshOf("/dev/fd/63", obj).numFaces(), 1u);
  EXPECT_EQ(meshOf("a.obj", obj).numFaces(), 1u);
  EXPECT_TRUE(containsInOrder(meshError("a.ply", obj), {"a.ply:1: ", "'v 0 0 0'", "'ply'"}));
  EXPECT_TRUE(containsInOrder(meshError("a.obj", text), {"a.obj:1: ", "'solid'"}));
  EXPECT_TRUE(containsInOrder(meshError("a.dae", stl), {"a.dae:1: ", "OBJ"}));
}

TEST(MeshFiles, ObjHasOneVertexPerPositionAndAllFormsOfCorners) {
  const PolygonMesh mesh =
      meshOf("a.obj", "v 0 0 0\nv 1000000.123456 0 0\nv 1 1 0\nv 0 1 0\nv 2 2 2\n"
                      "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nvn 0 1 0\n"
                      "f 1/1/1 2/2/1 3/3/2\nf -5/1 -3/2 -2/3\nf 1//1 2//2 3//1 4//2 5//1\nf 1 2 3 4\n");
  EXPECT_EQ(mesh.positions.size(), 5u) << "seams of texture coordinates and normals split no vertex";
  EXPECT_EQ(mesh.faceSizes, (Corners{3, 3, 5, 4}));
  EXPECT_EQ(mesh.faceIndices, (Corners{0, 1, 2, 0, 2, 3, 0, 1, 2, 3, 4, 0, 1, 2, 3}));
  EXPECT_EQ(mesh.positions[1].x, 1000000.123456) << "no rounding to floats";
}

TEST(MeshFiles, HolesOfObjFilesAreLeftOut) {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 2 3\nf 2 3 4\n";
  EXPECT_EQ(meshOf("a.obj", text + "t hole 1/0/0 1\n").faceIndices, (Corners{0, 1, 2, 3, 1, 2, 3}));
  EXPECT_TRUE(containsInOrder(meshError("a.obj", text + "t hole 3/0/0 0 1 2\n"), {"all faces are holes"}));
}

TEST(MeshFiles, RoundingThatMovesVerticesCausesAWarning) {
  PolygonMesh mesh;
  mesh.positions = {{0.1, 0.2, 0.3}, {1, 1, 1}};
  std::string warnings;
  roundedPositions(mesh, "a.ply", warnings);
  EXPECT_EQ(warnings, "");
  for (Vec3d& p : mesh.positions) p = p + Vec3d{5e6, 0, 0};
  roundedPositions(mesh, "a.ply", warnings);
  EXPECT_TRUE(containsInOrder(warnings, {"a.ply: ", "0.1", "origin", "\n"}));
}

/* --- polygons -------------------------------------------------------------------------- */

PolygonMesh polygon(const std::vector<Vec3d>& corners) {
  PolygonMesh mesh;
  mesh.positions = corners;
  mesh.faceSizes = {unsigned(corners.size())};
  for (unsigned i = 0; i < corners.size(); i++) mesh.faceIndices.push_back(i);
  return mesh;
}

Vec3d areaOf(const std::vector<Vec3d>& p, const unsigned* v) {
  return cross(p[v[1]] - p[v[0]], p[v[2]] - p[v[0]]) * 0.5;
}

/* The triangles of a flat polygon have its orientation, and their areas add up to its own. */
void expectExactTriangles(const std::vector<Vec3d>& corners) {
  PolygonMesh mesh = polygon(corners);
  const MeshPrimitives split = splitPolygons(mesh);
  ASSERT_EQ(split.corners, 3u);
  ASSERT_EQ(split.size(), corners.size() - 2);
  EXPECT_EQ(split.faces, std::vector<unsigned>(split.size(), 0u));
  Vec3d whole;
  for (size_t i = 0; i < corners.size(); i++)
    whole += cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]) * 0.5;
  double area = 0;
  for (size_t t = 0; t < split.size(); t++) {
    const Vec3d one = areaOf(corners, &split.indices[3 * t]);
    EXPECT_GE(dot(one, whole), -1e-9 * dot(whole, whole)) << "triangle " << t << " is inside out";
    area += length(one);
  }
  EXPECT_NEAR(area, length(whole), 1e-9 * length(whole));
}

/* To a plane of any orientation far from the origin. */
std::vector<Vec3d> placed(std::vector<Vec3d> corners, int orientation) {
  for (Vec3d& p : corners) {
    const Vec3d q = orientation % 3 == 0 ? p : orientation % 3 == 1 ? Vec3d{p.z, p.x, p.y} : Vec3d{p.y, p.z, p.x};
    p = q + Vec3d{5e5, -3e5, 7};
  }
  if (orientation >= 3) std::reverse(corners.begin(), corners.end());
  return corners;
}

TEST(Polygons, ConcaveOnesAreCoveredExactly) {
  const std::vector<Vec3d> shapes[] = {
      {{0, 0, 0}, {4, 0, 0}, {4, 1, 0}, {1, 1, 0}, {1, 4, 0}, {0, 4, 0}}, // an L
      {{1, 1, 0}, {1, 4, 0}, {0, 4, 0}, {0, 0, 0}, {4, 0, 0}, {4, 1, 0}}, // begins inside
      {{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}},            // corner on an edge
      {{0, 0, 0},
       {6, 0, 0},
       {6, 6, 0},
       {0, 6, 0},
       {0, 0, 0},
       {2, 2, 0},
       {2, 4, 0},
       {4, 4, 0},
       {4, 2, 0},
       {2, 2, 0}},                                                                              // a hole
      {{0, 0, 0}, {1, 0, 0}, {1, 3, 0}, {2, 3, 0}, {2, 0, 0}, {3, 0, 0}, {3, 4, 0}, {0, 4, 0}}, // a U
      {{0, 0, 0}, {4, 0, 2}, {4, 4, 4}, {2, 1, 1.5}, {0, 4, 2}},                                // inclined
  };
  for (int orientation = 0; orientation < 6; orientation++)
    for (const std::vector<Vec3d>& shape : shapes) {
      SCOPED_TRACE(testing::Message() << shape.size() << " corners, orientation " << orientation);
      expectExactTriangles(placed(shape, orientation));
    }
}

TEST(Polygons, StarsOfManyCorners) {
  Random random(7);
  for (const unsigned corners : {5u, 17u, 300u, 1500u}) {
    std::vector<Vec3d> star;
    for (unsigned i = 0; i < corners; i++) {
      const double angle = 2 * 3.14159265358979 * i / corners, radius = 1 + random.below(1000) * 0.01;
      star.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    }
    for (int orientation = 0; orientation < 6; orientation++) expectExactTriangles(placed(star, orientation));
  }
}

TEST(Polygons, OthersKeepTheirNumberOfTriangles) {
  const std::vector<Vec3d> shapes[] = {std::vector<Vec3d>(7), // a point
                                       {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {1.5, 0, 0}},
                                       {{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 2, 0}, {-1, 1, 0}}}; // intersects itself
  for (const std::vector<Vec3d>& shape : shapes) {
    PolygonMesh mesh = polygon(shape);
    EXPECT_EQ(splitPolygons(mesh).size(), shape.size() - 2);
  }
}

TEST(Polygons, TrianglesAndQuadsStayAndConcaveQuadsBeginElsewhere) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0.5, 1, 0}};
  mesh.faceSizes = {4, 3, 5, 4, 4};
  mesh.faceIndices = {0, 1, 2, 3, 0, 1, 2, 0, 1, 4, 2, 3, 4, 2, 3, 0, 3, 0, 4, 2};
  PolygonMesh exported = mesh;
  exported.splitsAreExplicit = true;
  const MeshPrimitives split = splitPolygons(mesh), asStored = splitPolygons(exported);
  EXPECT_EQ(split.corners, 4u);
  EXPECT_EQ(split.size(), 7u);
  EXPECT_EQ(split.faces, (std::vector<unsigned>{0, 1, 2, 2, 2, 3, 4}));
  const auto row = [](const MeshPrimitives& of, size_t i) {
    return Corners(of.indices.begin() + ptrdiff_t(4 * i), of.indices.begin() + ptrdiff_t(4 * i + 4));
  };
  EXPECT_EQ(row(split, 0), (Corners{0, 1, 2, 3}));
  EXPECT_EQ(row(split, 1), (Corners{0, 1, 2, 2}));
  EXPECT_EQ(row(split, 5), (Corners{2, 3, 0, 4})) << "concave at its first corner";
  EXPECT_EQ(row(asStored, 5), (Corners{4, 2, 3, 0}));
  EXPECT_EQ(row(split, 6), (Corners{0, 4, 2, 3})) << "concave at its third corner";
}

}} // namespace programs::test
