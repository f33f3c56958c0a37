// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Mistakes of other readers that the tests exclude: coordinates rounded to floats, the number of corners modulo 256,
 * only the first corners of a polygon, only the first triangle of a strip, and types such as uint8 by one name only. */

#include "meshes/ply_reader.h"
#include "basics/text.h"
#include "meshes/ply_header.h"
#include "meshes/ply_values.h"

#include <algorithm>
#include <string>
#include <utility>

namespace programs {
namespace {

template<typename Values>
class PlyBody {
public:
  PlyBody(InputBytes& input, const PlyHeader& header, Values values)
    : input(input),
      header(header),
      values(std::move(values)) {}

  PolygonMesh run() {
    requireElements();
    for (const PlyElement& element : header.elements) {
      if (element.name == "vertex") readVertices(element);
      else if (element.name == "face") readFaces(element);
      else if (element.name == "tristrips") readStrips(element);
      else skip(element);
    }
    values.requireEnd();
    if (mesh.faceSizes.empty()) input.fail("no faces: expected at least one face");
    requireIndices();
    mesh.comments = header.comments;
    return std::move(mesh);
  }

private:
  const PlyElement* find(const char* name) const {
    for (const PlyElement& element : header.elements)
      if (element.name == name) return &element;
    return nullptr;
  }

  void requireElements() const {
    const PlyElement* const vertices = find("vertex");
    if (!vertices) input.fail("no element 'vertex': expected vertices and faces");
    if (!find("face") && !find("tristrips"))
      input.fail("no element 'face' or 'tristrips', only " + std::to_string(vertices->count) +
                 " vertices: expected a mesh with faces");
    for (const PlyElement& element : header.elements)
      if (element.count > mostMeshElements)
        input.fail("element '" + element.name + "' has " + std::to_string(element.count) + " items: expected at most " +
                   std::to_string(mostMeshElements));
  }

  void skip(const PlyProperty& property) { values.skip(property.type, property.isList ? listLength(property) : 1); }

  void skip(const PlyElement& element) {
    if (element.properties.empty()) return;
    for (uint64_t i = 0; i < element.count; i++) {
      values.begin(element, i);
      for (const PlyProperty& property : element.properties) skip(property);
      values.end();
    }
  }

  int64_t listLength(const PlyProperty& property) {
    const int64_t length = values.integer(property.countType);
    if (length < 0 || uint64_t(length) > mostMeshElements)
      values.fail("list '" + property.name + "' has " + std::to_string(length) + " items: expected 0 or more");
    return length;
  }

  void readVertices(const PlyElement& element) {
    std::vector<int> axes(element.properties.size(), -1);
    for (int axis = 0; axis < 3; axis++) {
      const char name[] = {char('x' + axis), 0};
      const int i = element.find(name);
      if (i < 0 || element.properties[size_t(i)].isList)
        input.fail(std::string("element 'vertex' has no number '") + name + "': expected x, y and z");
      axes[size_t(i)] = axis;
    }
    mesh.positions.reserve(input.capacityFor(element.count, element.leastBytes(header.format)));
    for (uint64_t i = 0; i < element.count; i++) {
      double position[3];
      values.begin(element, i);
      for (size_t p = 0; p < axes.size(); p++) {
        if (axes[p] >= 0) position[axes[p]] = values.real(element.properties[p].type);
        else skip(element.properties[p]);
      }
      values.end();
      for (const double x : position)
        if (!isCoordinate(x))
          values.fail("coordinate " + shortNumber(x) + ": expected a finite number that 32 bits can hold");
      mesh.positions.push_back({position[0], position[1], position[2]});
    }
  }

  /* Calls function(number of indices) before the indices of each element, which it must read. */
  template<typename Function>
  void readIndexLists(const PlyElement& element, const Function& function) {
    int list = element.find("vertex_indices");
    if (list < 0) list = element.find("vertex_index");
    if (list < 0 || !element.properties[size_t(list)].isList || !isInteger(element.properties[size_t(list)].type))
      input.fail("element '" + element.name + "' has no list of integers 'vertex_indices' or 'vertex_index'");
    for (uint64_t i = 0; i < element.count; i++) {
      values.begin(element, i);
      for (size_t p = 0; p < element.properties.size(); p++) {
        const PlyProperty& property = element.properties[p];
        if (int(p) == list) function(listLength(property), property.type);
        else skip(property);
      }
      values.end();
    }
  }

  unsigned index(PlyType type) {
    const int64_t value = values.integer(type);
    if (value < 0 || uint64_t(value) > mostMeshElements) failIndex(value);
    return unsigned(value);
  }

  [[noreturn]] void failIndex(int64_t value) const {
    values.fail("vertex index " + std::to_string(value) + " is out of range: the file has " +
                std::to_string(find("vertex")->count) + " vertices, numbered from 0");
  }

  void readFaces(const PlyElement& element) {
    const size_t leastCorners = header.format == PlyFormat::Ascii ? 6 : 3; // bytes
    mesh.reserveTriangles(input.capacityFor(element.count, element.leastBytes(header.format) + leastCorners));
    readIndexLists(element, [&](int64_t corners, PlyType type) {
      if (corners < 3) values.fail("the face has " + std::to_string(corners) + " vertices: expected at least 3");
      for (int64_t i = 0; i < corners; i++) mesh.faceIndices.push_back(index(type));
      mesh.faceSizes.push_back(unsigned(corners));
    });
  }

  /* -1 begins a new strip. */
  void readStrips(const PlyElement& element) {
    const uint64_t vertices = find("vertex")->count;
    readIndexLists(element, [&](int64_t length, PlyType type) {
      StripTriangles strip(mesh);
      for (int64_t i = 0; i < length; i++) {
        const int64_t vertex = values.integer(type);
        if (vertex == -1) strip.restart();
        else if (vertex < 0 || uint64_t(vertex) >= vertices) failIndex(vertex);
        else strip.add(unsigned(vertex));
      }
    });
  }

  /* At the end, because faces may precede the vertices. */
  void requireIndices() const {
    size_t corner = 0;
    for (size_t face = 0; face < mesh.numFaces(); face++)
      for (unsigned i = 0; i < mesh.faceSizes[face]; i++, corner++)
        if (mesh.faceIndices[corner] >= mesh.positions.size())
          input.fail("face " + std::to_string(face) + ": vertex index " + std::to_string(mesh.faceIndices[corner]) +
                     " is out of range: the file has " + std::to_string(mesh.positions.size()) +
                     " vertices, numbered from 0");
  }

  InputBytes& input;
  const PlyHeader& header;
  Values values;
  PolygonMesh mesh;
};

} // namespace

PolygonMesh readPly(InputBytes& input) {
  const PlyHeader header = readPlyHeader(input);
  if (header.format == PlyFormat::Ascii) return PlyBody<PlyText>(input, header, PlyText(input)).run();
  return PlyBody<PlyBinary>(input, header, PlyBinary(input, header.format == PlyFormat::BigEndian)).run();
}

} // namespace programs
