// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "arrays.h"
#include "classes.h"
#include "warning.h"

#include "basics/input_files.h"
#include "surface/cage.h"
#include "surface/cage_validation.h"
#include "surface/obj_reader.h"

#include <pybind11/stl/filesystem.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <numeric>

namespace programs::python {
namespace {

const std::vector<std::string> boundaryRules{"none", "edge_and_corner", "edge_only"}; // in order of BoundaryRule

/* Without faceSizes, `indices` has one row per face. */
void readFaces(const py::object& indices, const py::object& faceSizes, Cage& cage) {
  Shape shape;
  cage.faceIndices = python::indices(indices, "indices", cage.positions.size(), shape);
  if (faceSizes.is_none()) {
    if (shape.size() != 2 || shape[1] < 3)
      throwValueError("indices", "has shape " + shapeText(shape) +
                                     ": expected (n, k) with k >= 3, or face_vertex_counts for faces of several sizes");
    cage.faceSizes.assign(size_t(shape[0]), unsigned(shape[1]));
  } else {
    if (shape.size() != 1)
      throwValueError("indices", "has shape " + shapeText(shape) + ": expected (n,) together with face_vertex_counts");
    cage.faceSizes = indexVector(faceSizes, "face_vertex_counts", UINT32_MAX);
    for (size_t i = 0; i < cage.faceSizes.size(); i++)
      if (cage.faceSizes[i] < 3)
        throwValueError("face_vertex_counts", "face " + std::to_string(i) + " has " +
                                                  std::to_string(cage.faceSizes[i]) + " vertices: expected at least 3");
    const size_t sum = std::accumulate(cage.faceSizes.begin(), cage.faceSizes.end(), size_t(0));
    if (sum != cage.faceIndices.size())
      throwValueError("face_vertex_counts", "adds up to " + std::to_string(sum) + ": expected the number of indices, " +
                                                std::to_string(cage.faceIndices.size()));
  }
  if (cage.faceSizes.empty()) throwValueError("indices", "has no faces: expected at least one");
}

void readUVs(const py::object& uvs, const py::object& uvIndices, Cage& cage) {
  if (uvs.is_none()) {
    if (!uvIndices.is_none()) throwValueError("uv_indices", "is given without uvs: expected both");
    return;
  }
  cage.uvs = vec2Vector(uvs, "uvs");
  if (uvIndices.is_none()) {
    if (cage.uvs.size() != cage.positions.size())
      throwValueError("uvs", "has " + std::to_string(cage.uvs.size()) + " rows: expected one per vertex, " +
                                 std::to_string(cage.positions.size()) + ", or uv_indices");
    cage.uvIndices = cage.faceIndices;
    return;
  }
  Shape shape;
  cage.uvIndices = indices(uvIndices, "uv_indices", cage.uvs.size(), shape, Cage::noUV);
  if (cage.uvIndices.size() != cage.faceIndices.size())
    throwValueError("uv_indices", "has " + std::to_string(cage.uvIndices.size()) +
                                      " elements: expected the number of indices, " +
                                      std::to_string(cage.faceIndices.size()));
  size_t first = 0;
  for (size_t face = 0; face < cage.numFaces(); first += cage.faceSizes[face++])
    for (size_t corner = first; corner < first + cage.faceSizes[face]; corner++)
      if ((cage.uvIndices[corner] == Cage::noUV) != (cage.uvIndices[first] == Cage::noUV))
        throwValueError("uv_indices", "face " + std::to_string(face) +
                                          " has texture coordinates at some corners: "
                                          "expected all corners or none");
  if (cage.numFacesWithoutUVs() == cage.numFaces()) {
    cage.uvs.clear();
    cage.uvIndices.clear();
  }
}

/* One value for each of n edges or corners, or one for all. None means infinitely sharp. */
std::vector<float> readSharpness(const py::object& value, const std::string& argument, size_t n) {
  if (value.is_none()) return std::vector<float>(n, INFINITY);
  const Floats array = floats(value, argument);
  std::vector<float> sharpness =
      array.ndim() == 0 ? std::vector<float>(n, *array.data()) : floatVector(value, argument);
  if (sharpness.size() != n)
    throwValueError(argument, "has " + std::to_string(sharpness.size()) + " elements: expected " + std::to_string(n));
  for (float& s : sharpness) {
    if (!(s >= 0.0f)) throwValueError(argument, "contains " + std::to_string(s) + ": expected 0 or more");
    s = sharpnessOf(s);
  }
  return sharpness;
}

/* Warns and makes holes of faces that Embree does not support. */
std::shared_ptr<Cage> checked(std::shared_ptr<Cage> cage) {
  std::string warnings;
  validateCage(*cage, warnings);
  warn(warnings);
  return cage;
}

std::shared_ptr<Cage> makeCage(const py::object& vertices, const py::object& indices, const py::object& faceSizes,
                               const py::object& uvs, const py::object& uvIndices, const py::object& creaseEdges,
                               const py::object& creaseSharpness, const py::object& cornerVertices,
                               const py::object& cornerSharpness, const py::object& holes, const std::string& boundary,
                               const std::string& name) {
  auto cage = std::make_shared<Cage>();
  cage->name = name;
  cage->positions = vec3Vector(vertices, "vertices");
  const size_t n = cage->positions.size();
  readFaces(indices, faceSizes, *cage);
  readUVs(uvs, uvIndices, *cage);
  cage->creaseEdges = indexPairs(creaseEdges, "crease_edges", n);
  cage->creaseSharpness = readSharpness(creaseSharpness, "crease_sharpness", cage->creaseEdges.size());
  cage->cornerVertices = indexVector(cornerVertices, "corner_vertices", n);
  cage->cornerSharpness = readSharpness(cornerSharpness, "corner_sharpness", cage->cornerVertices.size());
  cage->holes = indexVector(holes, "holes", cage->numFaces());
  cage->boundary = BoundaryRule(choice(boundary, "boundary", boundaryRules));
  return checked(std::move(cage));
}

std::shared_ptr<Cage> loadCage(const std::filesystem::path& path) {
  std::string warnings;
  auto cage = std::make_shared<Cage>(readObj(path.string(), warnings));
  recordInputFile(path.string());
  warn(warnings);
  return checked(std::move(cage));
}

template<typename T, typename Element>
auto array(std::vector<Element> Cage::* member) {
  return [member](const py::object& self) { return view<T>(self.cast<const Cage&>().*member, self); };
}

constexpr const char* cageText = R"(Control cage of a Catmull-Clark subdivision surface, checked by OpenSubdiv.

The arrays are read-only views, except bounds, which is a copy. Corners of faces are counterclockwise as seen from the
front.)";

constexpr const char* makeText = R"(Creates a cage from arrays.

vertices: (n, 3), finite, in any unit.
indices: (f, k) integers, the vertices of f faces with k corners each; or, with face_vertex_counts,
  (sum(face_vertex_counts),), the vertices of all faces one after the other. Embree supports up to 16 corners per face
  and 1024 faces around a vertex (1023 at a border).
face_vertex_counts: (f,) integers, the number of corners of each face, at least 3.
uvs: (m, 2), texture coordinates; (0, 0) is the lower left corner of an image, (1, 1) the upper right.
uv_indices: parallel to indices, indices of the corners' texture coordinates, or 4294967295 at all corners of a face
  without coordinates. If omitted, uvs has one row per vertex.
crease_edges: (c, 2) integers, the vertices of edges.
crease_sharpness: (c,) or one number, at least 0; 10 and more mean a hard edge, as in OpenSubdiv and USD, and are stored
  as inf, the default.
corner_vertices, corner_sharpness: (c,) each, the same for vertices.
holes: (h,) integers, faces without surface.
boundary: the shape at boundary edges: "edge_only", a smooth curve; "edge_and_corner", the same with sharp corners;
  "none", faces at the boundary have no surface.
name: name of the cage in messages.

Raises ValueError or TypeError that names an invalid argument, and Error if OpenSubdiv rejects the topology. Messages
about the topology count faces and vertices from 1, as OBJ files do.)";

} // namespace

void defineCage(py::module_& module) {
  const py::tuple none;
  py::class_<Cage, std::shared_ptr<Cage>>(module, "Cage", cageText)
      .def(py::init(&makeCage), py::arg("vertices"), py::arg("indices"), py::arg("face_vertex_counts") = py::none(),
           py::kw_only(), py::arg("uvs") = py::none(), py::arg("uv_indices") = py::none(),
           py::arg("crease_edges") = none, py::arg("crease_sharpness") = py::none(), py::arg("corner_vertices") = none,
           py::arg("corner_sharpness") = py::none(), py::arg("holes") = none, py::arg("boundary") = "edge_only",
           py::arg("name") = "cage", makeText)
      .def_static("load", &loadCage, py::arg("path"),
                  R"(Reads a Wavefront OBJ file, with OpenSubdiv's `t` tags for creases, corners, holes and boundaries.

path: of the file, str or os.PathLike.

Raises Error with the line for a file that cannot be read, and Error if OpenSubdiv rejects the topology.)")
      .def_property_readonly(
          "name", [](const Cage& c) { return stringOf(c.name); }, "Name in messages.")
      .def_property_readonly("vertices", array<float>(&Cage::positions), "(n, 3) float32: control points.")
      .def_property_readonly("face_vertex_counts", array<unsigned>(&Cage::faceSizes),
                             "(f,) uint32: corners of each face.")
      .def_property_readonly("indices", array<unsigned>(&Cage::faceIndices),
                             "(sum(face_vertex_counts),) uint32: vertices of the faces, one after the other.")
      .def_property_readonly("uvs", array<float>(&Cage::uvs), "(m, 2) float32: texture coordinates; (0, 2) if none.")
      .def_property_readonly(
          "uv_indices", array<unsigned>(&Cage::uvIndices),
          "Parallel to indices, uint32: indices into uvs, 4294967295 on faces without; (0,) if none.")
      .def_property_readonly("crease_edges", array<unsigned>(&Cage::creaseEdges), "(c, 2) uint32: vertices of creases.")
      .def_property_readonly("crease_sharpness", array<float>(&Cage::creaseSharpness), "(c,) float32: inf if hard.")
      .def_property_readonly("corner_vertices", array<unsigned>(&Cage::cornerVertices), "(c,) uint32: sharp vertices.")
      .def_property_readonly("corner_sharpness", array<float>(&Cage::cornerSharpness), "(c,) float32: inf if hard.")
      .def_property_readonly("holes", array<unsigned>(&Cage::holes), "(h,) uint32: faces without surface.")
      .def_property_readonly(
          "boundary", [](const Cage& c) { return boundaryRules[size_t(c.boundary)]; },
          "The shape at boundary edges, see the constructor.")
      .def_property_readonly(
          "bounds", [](const Cage& c) { return arrayOf(c.bounds()); },
          "(2, 3) float32: lower and upper corner of the bounding box of all vertices with faces.")
      .def("__repr__", [](const Cage& c) {
        return stringOf("<Cage '" + c.name + "' of " + std::to_string(c.numFaces()) + " faces and " +
                        std::to_string(c.positions.size()) + " vertices>");
      });
}

} // namespace programs::python
