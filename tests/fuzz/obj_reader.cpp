// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Fuzz target: arbitrary bytes as an OBJ file. The reader returns a cage whose indices are in range and whose numbers
// are finite, or throws an Error of one line that starts with the name of the file.

#include "fuzz_input.h"
#include "support/obj_dialects.h"

#include "basics/error.h"
#include "surface/obj_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <sstream>

namespace programs::test {
namespace {

constexpr const char* name = "cage.obj";

bool allBelow(const std::vector<unsigned>& indices, size_t count) {
  return std::all_of(indices.begin(), indices.end(), [&](unsigned i) { return i < count; });
}

void checkTextureCoordinates(const Cage& cage) {
  REQUIRE(cage.uvIndices.empty() ? cage.uvs.empty() : cage.uvIndices.size() == cage.faceIndices.size());
  for (const Vec2f& uv : cage.uvs) REQUIRE(std::isfinite(uv.x) && std::isfinite(uv.y));
  if (!cage.hasUVs()) return;
  size_t without = 0, corner = 0;
  for (unsigned size : cage.faceSizes) {
    const bool isWithout = cage.uvIndices[corner] == Cage::noUV;
    without += isWithout;
    for (unsigned i = 0; i < size; i++, corner++)
      REQUIRE(isWithout ? cage.uvIndices[corner] == Cage::noUV : cage.uvIndices[corner] < cage.uvs.size());
  }
  REQUIRE(without == cage.numFacesWithoutUVs());
  REQUIRE(without < cage.numFaces() && (without == 0) == (cage.lineWithoutUVs == 0));
}

void check(const Cage& cage) {
  REQUIRE(cage.numFaces() > 0);
  REQUIRE(std::all_of(cage.faceSizes.begin(), cage.faceSizes.end(), [](unsigned size) { return size >= 3; }));
  REQUIRE(std::accumulate(cage.faceSizes.begin(), cage.faceSizes.end(), size_t(0)) == cage.faceIndices.size());
  REQUIRE(allBelow(cage.faceIndices, cage.positions.size()));
  for (const Vec3f& p : cage.positions) REQUIRE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  checkTextureCoordinates(cage);
  REQUIRE(allBelow(cage.cornerVertices, cage.positions.size()) && allBelow(cage.holes, cage.numFaces()));
  for (auto [a, b] : cage.creaseEdges) REQUIRE(a < cage.positions.size() && b < cage.positions.size());
  REQUIRE(cage.creaseSharpness.size() == cage.creaseEdges.size());
  REQUIRE(cage.cornerSharpness.size() == cage.cornerVertices.size());
  for (float s : cage.creaseSharpness) REQUIRE(s >= 0);
  for (float s : cage.cornerSharpness) REQUIRE(s >= 0);
}

bool isPrintable(const std::string& lines) {
  return std::all_of(lines.begin(), lines.end(), [](char c) { return c == '\n' || (c >= ' ' && c <= '~'); });
}

} // namespace

void writeSeeds(const std::string& folder) {
  size_t n = 0;
  for (const ObjDialect& dialect : objDialects()) writeSeed(folder + "/" + std::to_string(n++), dialect.text);
}

} // namespace programs::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace ::programs::test;
  std::istringstream stream(std::string(reinterpret_cast<const char*>(data), size));
  std::string warnings;
  try {
    check(::programs::readObj(stream, name, warnings));
  } catch (const ::programs::Error& e) {
    const std::string message = e.what();
    REQUIRE(message.rfind(name, 0) == 0 && message.find('\n') == std::string::npos && isPrintable(message));
  }
  REQUIRE(isPrintable(warnings));
  return 0;
}
