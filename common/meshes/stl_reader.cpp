// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "meshes/stl_reader.h"
#include "basics/text.h"
#include "meshes/position_table.h"

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <string>
#include <utility>

namespace programs {
namespace {

constexpr size_t headerBytes = 80, firstTriangle = 84, triangleBytes = 50;

uint32_t littleEndian(const uint8_t* bytes) {
  return uint32_t(bytes[0]) | uint32_t(bytes[1]) << 8 | uint32_t(bytes[2]) << 16 | uint32_t(bytes[3]) << 24;
}

/* Triangles of both forms. */
class StlTriangles {
public:
  explicit StlTriangles(InputBytes& input) : input(input), table(mesh.positions) {}

  void reserve(size_t triangles) { mesh.reserveTriangles(triangles); }

  /* Returns the index of a vertex. */
  unsigned addVertex(const Vec3d& position) {
    if (mesh.positions.size() == mostMeshElements)
      input.fail("too many vertices: expected at most " + std::to_string(mostMeshElements));
    return table.add(position);
  }

  void addTriangle(const unsigned (&corners)[3]) { mesh.addTriangle(corners[0], corners[1], corners[2]); }

  PolygonMesh finish() {
    if (mesh.faceSizes.empty()) input.fail("no triangles: expected at least one");
    return std::move(mesh);
  }

private:
  InputBytes& input;
  PolygonMesh mesh;
  PositionTable table;
};

class StlText {
public:
  explicit StlText(InputBytes& input) : input(input), triangles(input) {}

  PolygonMesh run() {
    while (nextLine()) {
      expect({"solid"});
      for (;;) {
        if (!nextLine()) input.fail("the file ends within a solid: expected 'endsolid'");
        if (startsWith("endsolid")) break;
        readFacet();
      }
    }
    return triangles.finish();
  }

private:
  /* Returns false if no line with a word follows. */
  bool nextLine() {
    do {
      if (!input.readLine(line)) return false;
      if (input.lineNumber() == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") line.remove_prefix(3);
      rest = line;
    } while (nextWord(rest).empty());
    rest = line;
    return true;
  }

  bool startsWith(const char* word) const {
    std::string_view words = line;
    return lowerCase(std::string(nextWord(words))) == word;
  }

  /* Requires these words at the beginning of the line. */
  void expect(std::initializer_list<const char*> words) {
    std::string all;
    for (const char* word : words) all += (all.empty() ? "" : " ") + std::string(word);
    for (const char* word : words)
      if (lowerCase(std::string(nextWord(rest))) != word)
        input.failAtLine(quotedWord(line) + ": expected '" + all + "'");
  }

  void expectLine(std::initializer_list<const char*> words) {
    if (!nextLine()) input.fail("the file ends within a triangle: expected '" + std::string(*words.begin()) + "'");
    expect(words);
  }

  void expectEndOfLine() {
    const std::string_view word = nextWord(rest);
    if (!word.empty()) input.failAtLine(quotedWord(word) + ": expected the end of the line");
  }

  void readFacet() {
    expect({"facet", "normal"});
    expectLine({"outer", "loop"});
    unsigned corners[3];
    for (unsigned& corner : corners) {
      expectLine({"vertex"});
      const double x = coordinate(), y = coordinate(), z = coordinate();
      expectEndOfLine();
      corner = triangles.addVertex({x, y, z});
    }
    expectLine({"endloop"});
    expectLine({"endfacet"});
    triangles.addTriangle(corners);
  }

  double coordinate() {
    const std::string_view word = nextWord(rest);
    double value;
    if (!parseReal(word, value) || !isCoordinate(value))
      input.failAtLine("coordinate " + quotedWord(word) + ": expected a finite number that 32 bits can hold");
    return value;
  }

  InputBytes& input;
  StlTriangles triangles;
  std::string_view line, rest;
};

/* Headers of binary files may begin with "solid", too. */
bool isText(InputBytes& input) {
  const size_t buffered = input.require(4096);
  const uint8_t* const bytes = input.data();
  if (buffered >= firstTriangle &&
      input.following() == firstTriangle + uint64_t(triangleBytes) * littleEndian(bytes + headerBytes))
    return false;
  std::string_view text(reinterpret_cast<const char*>(bytes), buffered);
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  std::string_view words = text.substr(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  if (lowerCase(std::string(words.substr(0, 5))) != "solid") return false;
  words.remove_prefix(std::min(words.find_first_of("\r\n"), words.size()));
  words.remove_prefix(std::min(words.find_first_not_of(" \t\r\n"), words.size()));
  if (words.empty()) return std::find(text.begin(), text.end(), '\0') == text.end();
  const std::string first = lowerCase(std::string(words.substr(0, 8)));
  return first.substr(0, 5) == "facet" || first == "endsolid";
}

PolygonMesh readBinary(InputBytes& input) {
  if (input.require(firstTriangle) < firstTriangle)
    input.fail("the file has " + std::to_string(input.require(0)) +
               " bytes and does not begin with 'solid': expected an STL file, of at least 84 bytes");
  const uint64_t count = littleEndian(input.data() + headerBytes), size = input.following();
  const uint64_t expected = firstTriangle + triangleBytes * count;
  if (size != ~uint64_t(0) && size != expected)
    input.fail("the file has " + std::to_string(size) + " bytes: expected " + std::to_string(expected) + " for the " +
               std::to_string(count) + " triangles of its header");
  input.skip(firstTriangle);
  StlTriangles triangles(input);
  triangles.reserve(input.capacityFor(count, triangleBytes));
  for (uint64_t i = 0; i < count; i++) {
    if (input.require(triangleBytes) < triangleBytes)
      input.fail("the file ends within triangle " + std::to_string(i) + ": expected " + std::to_string(count));
    unsigned corners[3];
    for (size_t corner = 0; corner < 3; corner++) {
      float p[3];
      for (size_t axis = 0; axis < 3; axis++) {
        const uint32_t bits = littleEndian(input.data() + 12 + 12 * corner + 4 * axis);
        std::memcpy(&p[axis], &bits, sizeof(bits));
        if (!isCoordinate(double(p[axis])))
          input.fail("triangle " + std::to_string(i) + ": coordinate " + shortNumber(double(p[axis])) +
                     ": expected a finite number");
      }
      corners[corner] = triangles.addVertex(Vec3d{double(p[0]), double(p[1]), double(p[2])});
    }
    triangles.addTriangle(corners);
    input.skip(triangleBytes);
  }
  if (!input.atEnd())
    input.fail("data follows the last of " + std::to_string(count) + " triangles: expected the end of the file");
  return triangles.finish();
}

} // namespace

PolygonMesh readStl(InputBytes& input) { return isText(input) ? StlText(input).run() : readBinary(input); }

} // namespace programs
