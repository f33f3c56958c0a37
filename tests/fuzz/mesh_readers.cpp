// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Fuzz target: arbitrary bytes as a PLY, STL or glTF file, selected by the first byte. The reader returns a mesh whose
// indices are in range and whose coordinates 32 bits can hold, which splits into triangles and quads, or throws an
// Error of one line that starts with the name of the file.

#include "fuzz_input.h"
#include "support/mesh_bytes.h"

#include "basics/error.h"
#include "meshes/mesh_file.h"
#include "meshes/polygon_triangles.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <sstream>

namespace programs::test {
namespace {

const std::string names[] = {"mesh.ply", "mesh.stl", "mesh.gltf"};

bool isPrintable(const std::string& lines) {
  return std::all_of(lines.begin(), lines.end(), [](char c) { return c == '\n' || (c >= ' ' && c <= '~'); });
}

void check(PolygonMesh mesh) {
  REQUIRE(mesh.numFaces() > 0);
  size_t primitives = 0;
  for (const unsigned size : mesh.faceSizes) {
    REQUIRE(size >= 3);
    primitives += size > 4 ? size - 2 : 1;
  }
  REQUIRE(std::accumulate(mesh.faceSizes.begin(), mesh.faceSizes.end(), size_t(0)) == mesh.faceIndices.size());
  for (const Vec3d& p : mesh.positions) REQUIRE(isCoordinate(p.x) && isCoordinate(p.y) && isCoordinate(p.z));
  std::string warnings;
  REQUIRE(roundedPositions(mesh, names[0], warnings).size() == mesh.positions.size());
  const MeshPrimitives split = splitPolygons(mesh);
  REQUIRE(split.size() == primitives);
  for (const unsigned i : split.indices) REQUIRE(i < mesh.positions.size());
}

} // namespace

void writeSeeds(const std::string& folder) {
  const std::string facet = stlFacet(square[0], square[1], square[2]);
  const std::string strips = plyHeader("ascii", "element vertex 3\nproperty int x\nproperty int y\nproperty int z\n"
                                                "element tristrips 1\nproperty list int int vertex_indices\n");
  const std::string document = gltf(squareBuffer(), squareViews, squareAccessors, squareMesh + oneMesh);
  const std::string inChunk = gltf(squareBuffer(), squareViews, squareAccessors, squareMesh + oneMesh, "none");
  const std::string seeds[] = {std::string(1, 0) + binaryPly(false),
                               std::string(1, 0) + binaryPly(true),
                               std::string(1, 0) + strips + "0 0 0\n1 0 0\n0 1 0\n4 0 1 2 -1\n",
                               std::string(1, 1) + binaryStl({0, 0, 0, 1, 0, 0, 0, 1, 0}),
                               std::string(1, 1) + "solid a\n" + facet + "endsolid\nsolid b\n" + facet + "endsolid b\n",
                               std::string(1, 2) + document,
                               std::string(1, 2) + glb(inChunk, squareBuffer())};
  for (size_t i = 0; i < std::size(seeds); i++) writeSeed(folder + "/" + std::to_string(i), seeds[i]);
}

} // namespace programs::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace ::programs::test;
  if (size == 0) return 0;
  const std::string& name = names[data[0] % 3];
  std::istringstream stream(std::string(reinterpret_cast<const char*>(data) + 1, size - 1));
  std::string warnings;
  try {
    check(::programs::readMesh(stream, name, warnings));
  } catch (const ::programs::Error& e) {
    const std::string message = e.what();
    REQUIRE(message.rfind(name, 0) == 0 && message.find('\n') == std::string::npos && isPrintable(message));
  }
  REQUIRE(isPrintable(warnings));
  return 0;
}
