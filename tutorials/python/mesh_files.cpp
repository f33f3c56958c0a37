// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Files of meshes: read_mesh() and Mesh.load(). */

#include "arrays.h"
#include "classes.h"
#include "interruptible.h"
#include "warning.h"

#include "meshes/mesh_file.h"
#include "meshes/polygon_triangles.h"

#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

namespace programs::python {
namespace {

/* An array of shape (n, width), or (n,) for width 1, that owns the elements. */
template<typename T, typename Element>
py::array arrayFrom(std::vector<Element>&& elements, size_t width) {
  auto* const owned = new std::vector<Element>(std::move(elements));
  const py::capsule owner(owned, [](void* p) { delete static_cast<std::vector<Element>*>(p); });
  const py::ssize_t n = py::ssize_t(owned->size() * sizeof(Element) / sizeof(T) / width);
  const T* const data = reinterpret_cast<const T*>(owned->data());
  return width == 1 ? py::array_t<T>({n}, data, owner) : py::array_t<T>({n, py::ssize_t(width)}, data, owner);
}

struct MeshArrays {
  PolygonMesh mesh;
  std::vector<Vec3f> rounded; // positions; empty unless they were asked for
  MeshPrimitives primitives;
  std::string warnings;
};

MeshArrays readArrays(const std::filesystem::path& path, bool round) {
  MeshArrays arrays = interruptibleQuery([&] {
    MeshArrays read;
    read.mesh = readMesh(path.string(), read.warnings);
    if (round) {
      read.rounded = roundedPositions(read.mesh, path.string(), read.warnings);
      read.mesh.positions = {};
    }
    read.primitives = splitPolygons(read.mesh);
    return read;
  });
  warn(arrays.warnings);
  return arrays;
}

py::array indicesOf(MeshArrays& arrays) {
  const size_t corners = arrays.primitives.corners;
  return arrayFrom<uint32_t>(std::move(arrays.primitives.indices), corners);
}

py::dict readMeshFile(const std::filesystem::path& path) {
  MeshArrays arrays = readArrays(path, false);
  std::vector<unsigned>& faces = arrays.primitives.faces;
  if (faces.empty()) {
    faces.resize(arrays.primitives.size());
    for (size_t i = 0; i < faces.size(); i++) faces[i] = unsigned(i);
  }
  py::dict result;
  result["vertices"] = arrayFrom<double>(std::move(arrays.mesh.positions), 3);
  result["faces"] = arrayFrom<uint32_t>(std::move(faces), 1);
  result["indices"] = indicesOf(arrays);
  return result;
}

/* Class of geometries.cpp. */
py::object loadMesh(const std::filesystem::path& path, const std::optional<float>& maxError) {
  MeshArrays arrays = readArrays(path, true);
  const py::array indices = indicesOf(arrays), vertices = arrayFrom<float>(std::move(arrays.rounded), 3);
  return py::module_::import("embree_cbvh").attr("Mesh")(vertices, indices, py::arg("max_error") = maxError);
}

constexpr const char* readMeshText = R"(Reads the triangles and polygons of an OBJ, PLY, STL, glTF or GLB file.

path: of the file, str or os.PathLike.

Returns a dictionary:
  "vertices": (n, 3) float64, the coordinates of the file.
  "indices": (m, 3) or (m, 4) uint32, as Mesh accepts them. Faces of more than 4 corners become triangles, concave ones,
    too. Among quads, a triangle repeats its last index.
  "faces": (m,) uint32, the face of the file of each row of indices.

Triangles of glTF files are at the places of their nodes. Equal positions of an STL file are one vertex.

Raises Error with the line or the place for a file that is damaged, or that can be read only in part. Warns of points
and lines that are left out.)";

constexpr const char* loadText = R"(Reads a mesh from an OBJ, PLY, STL, glTF or GLB file.

path: of the file, str or os.PathLike.
max_error: as in Mesh.

Coordinates are rounded to float32, with a warning if that moves vertices by more than a millionth of the mesh's size:
then subtract an origin from the vertices of read_mesh(), which also describes what is read.

Raises Error with the line or the place for a file that is damaged, or that can be read only in part.)";

} // namespace

void defineMeshFiles(py::module_& module) {
  module.def("read_mesh", &readMeshFile, py::arg("path"), readMeshText);
  const py::object mesh = module.attr("Mesh");
  const py::cpp_function load(&loadMesh, py::name("load"), py::scope(mesh), py::arg("path"), py::kw_only(),
                              py::arg("max_error") = py::none(), loadText);
  mesh.attr("load") = py::staticmethod(load);
}

} // namespace programs::python
