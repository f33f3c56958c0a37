// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "classes.h"
#include "geometry.h"
#include "georeference.h"
#include "height_grid.h"
#include "scene.h"
#include "vertex_array.h"

#include "building/built_scene.h"
#include "surface/model.h"

#include <pybind11/stl.h>

#include <cmath>
#include <cstdint>

namespace programs::python {

CbvhError setGrid(CbvhSurface surface, size_t rows, size_t columns, size_t rowStride, const CbvhVertices& vertices) {
  const CbvhGrid grid = {0, unsigned(rowStride), (unsigned short)columns, (unsigned short)rows};
  CbvhGrids grids = CbvhGrids();
  grids.numGrids = 1;
  grids.grids = &grid;
  grids.vertices = vertices;
  return cbvhSetSurfaceGrids(surface, &grids);
}

size_t ModelGeometry::numPrimitives() const { return model->cage.numFaces(); }
unsigned ModelGeometry::steps() const { return unsigned(1 + model->poses.size()); }
std::string ModelGeometry::description() const {
  return "subdivision of '" + model->name + "' at level " + std::to_string(level);
}

namespace {

class Grid : public SurfaceGeometry {
public:
  explicit Grid(const py::object& points) : points(points, "points", 2) {
    const size_t rows = this->points.rows(), columns = this->points.columns();
    if (rows < 2 || columns < 2 || rows > mostSamples || columns > mostSamples)
      throwValueError("points", "has " + countText(rows, "row") + " and " + countText(columns, "column") +
                                    ": expected 2 to " + std::to_string(mostSamples) + " each");
  }

  size_t numPrimitives() const override { return 1; }
  unsigned steps() const override { return points.steps(); }
  std::string description() const override {
    return "grid of " + std::to_string(points.rows()) + " x " + std::to_string(points.columns()) + " points";
  }

  CbvhError setInput(CbvhSurface surface, std::vector<Vec3f>&) const override {
    return setGrid(surface, points.rows(), points.columns(), points.rowStride(), points.vertices(startTime, endTime));
  }

private:
  VertexArray points;
};

using Indices = py::array_t<uint32_t, py::array::c_style | py::array::forcecast>;
using Int32Array = py::array_t<int32_t, py::array::c_style | py::array::forcecast>;
using Int64Array = py::array_t<int64_t, py::array::c_style | py::array::forcecast>;

/* Requires shape (n, 3) or (n, 4). Integers of 32 bits in C order are not copied. */
Indices readIndices(const py::object& value, size_t numVertices) {
  py::array given = integers(value, "indices");
  const Shape shape = shapeOf(given);
  if (shape.size() != 2 || (shape[1] != 3 && shape[1] != 4))
    throwValueError("indices", "has shape " + shapeText(shape) + ": expected (n, 3) for triangles or (n, 4) for quads");
  if (shape[0] == 0) throwValueError("indices", "has no faces: expected at least one");
  if (uint64_t(shape[0]) >= UINT32_MAX)
    throwValueError("indices", "has " + std::to_string(shape[0]) + " faces: expected less than 2**32 - 1");
  const auto require = [&](const auto& all) {
    for (py::ssize_t i = 0; i < all.size(); i++)
      if (int64_t(all.data()[i]) < 0 || uint64_t(all.data()[i]) >= numVertices)
        throwValueError("indices", "face " + std::to_string(i / shape[1]) + " has index " +
                                       std::to_string(all.data()[i]) + ": expected 0 to " +
                                       std::to_string(int64_t(numVertices) - 1));
  };
  /* Of the same size and layout, numbers from 0 on are the same bits with or without sign. */
  if (py::isinstance<Int32Array>(given) && (given.flags() & py::array::c_style)) {
    require(Int32Array(given));
    return Indices(given.attr("view")("uint32"));
  }
  if (given.dtype().kind() == 'i' || given.itemsize() > 4) require(Int64Array(given));
  const Indices result(given);
  require(result);
  return result;
}

class Mesh : public SurfaceGeometry {
public:
  Mesh(const py::object& vertices, const py::object& indices)
    : points(vertices, "vertices", 1),
      indices(readIndices(indices, points.columns())) {}

  size_t numPrimitives() const override { return size_t(indices.shape(0)); }
  unsigned steps() const override { return points.steps(); }
  std::string description() const override {
    return "mesh of " + countText(numPrimitives(), indices.shape(1) == 3 ? "triangle" : "quad");
  }

  CbvhError setInput(CbvhSurface surface, std::vector<Vec3f>&) const override {
    CbvhMesh mesh = CbvhMesh();
    mesh.verticesPerFace = unsigned(indices.shape(1));
    mesh.numFaces = numPrimitives();
    mesh.indices = indices.data();
    mesh.vertices = points.vertices(startTime, endTime);
    return cbvhSetSurfaceMesh(surface, &mesh);
  }

private:
  VertexArray points;
  Indices indices;
};

/* --- settings that all geometries share ------------------------------------------ */

template<typename T>
std::shared_ptr<T> withMaxError(std::shared_ptr<T> geometry, const std::optional<float>& maxError) {
  if (maxError) requireNotNegative(*maxError, "max_error");
  geometry->maxError = maxError;
  return geometry;
}

template<typename T>
std::shared_ptr<T> withSettings(std::shared_ptr<T> geometry, const std::optional<float>& maxError,
                                std::pair<float, float> times) {
  if (!(times.first < times.second) || !std::isfinite(times.first) || !std::isfinite(times.second))
    throwValueError("times", "is (" + std::to_string(times.first) + ", " + std::to_string(times.second) +
                                 "): expected two finite numbers, the first one below the second");
  geometry->startTime = times.first;
  geometry->endTime = times.second;
  return withMaxError(std::move(geometry), maxError);
}

std::shared_ptr<Grid> makeGrid(const py::object& points, const std::optional<float>& maxError,
                               std::pair<float, float> times) {
  return withSettings(std::make_shared<Grid>(points), maxError, times);
}

std::shared_ptr<HeightGrid> makeHeightGrid(const py::object& heights, const py::object& cell, const py::object& origin,
                                           const std::optional<float>& maxError, std::pair<float, float> times) {
  const std::pair<double, double> step = readCell(cell);
  return withSettings(std::make_shared<HeightGrid>(heights, vec3d(origin, "origin"), step.first, step.second), maxError,
                      times);
}

std::shared_ptr<Mesh> makeMesh(const py::object& vertices, const py::object& indices,
                               const std::optional<float>& maxError, std::pair<float, float> times) {
  return withSettings(std::make_shared<Mesh>(vertices, indices), maxError, times);
}

std::shared_ptr<ModelGeometry> makeSubdivision(const std::shared_ptr<Model>& model, int level,
                                               const std::optional<float>& maxError) {
  BuildSettings settings;
  settings.level = level;
  validateBuild(settings);
  if (model->copies.size() != 1)
    throwValueError("model", "has " + std::to_string(model->copies.size()) +
                                 " copies of its cage: expected one, or build() for such a model");
  return withMaxError(std::make_shared<ModelGeometry>(model, level), maxError);
}

/* --- docstrings ---------------------------------------------------------------- */

constexpr const char* gridText = R"(A grid of points: quads between neighboring rows and columns, one primitive.

Quad (row, column) is the triangle [row, column], [row, column + 1], [row + 1, column] and that of the other three
corners.)";

constexpr const char* makeGridText = R"(Creates a grid of points.

points: (rows, columns, 3), or (steps, rows, columns, 3) for a grid that moves linearly between up to 129 time steps; 2
  to 65535 rows and columns, finite.
max_error: bound on the spacing of the lattice on which points are stored, in units of the points. A point moves by at
  most half of it on each axis. 0 stores points exactly. None selects the library's default: 1/512 of the median edge.
times: of the first and of the last time step. There is no grid at other times. Rays have times from 0 to 1.

An array of float32 is not copied if its three coordinates are next to each other and its rows at equal distances. It is
read while a Scene is built: do not change it until then. Other numbers are rounded to float32.

Raises ValueError or TypeError that names an invalid argument.)";

constexpr const char* heightsText = R"(Creates a grid of heights at equal distances.

heights: (rows, columns), or (steps, rows, columns) for heights that move, 2 to 65535 rows and columns. NaN is a missing
  sample: triangles with it are left out.
cell: distance between samples, as in terrain(). A number c means (c, -c): columns go east, and rows from north to
  south. Two numbers are the steps of x per column and of y per row, and may be negative.
origin: (3,), position of sample [0, 0]. Sample [row, column] is at origin + (column * cell[0], row * cell[1], height).
  Ng of hits points downward if rows go south, and upward if they go north.
max_error, times: as in Grid.

An array of float32 is not copied. It is read while a Scene is built: do not change it until then. Positions are
computed in 64 bits and rounded to float32. For maps with large coordinates use terrain().

Raises ValueError or TypeError that names an invalid argument.)";

constexpr const char* meshText = "A mesh of triangles or quads, not subdivided.";

constexpr const char* makeMeshText = R"(Creates a mesh.

vertices: (n, 3), or (steps, n, 3) for a mesh that moves linearly between up to 129 time steps; finite.
indices: (m, 3) or (m, 4) integers, the vertices of triangles or quads. Corners are counterclockwise as seen from the
  front. A quad whose last two indices are equal is a triangle.
max_error: as in Grid. The library's default is 1/2048 of the median edge.
times: as in Grid.

Arrays of float32, and of 32-bit integers in C order, are not copied. They are read while a Scene is built: do not
change them until then. Other numbers are rounded to float32. Vertices with equal positions count as one.

Raises ValueError or TypeError that names an invalid argument.)";

constexpr const char* subdivisionText = "A subdivision surface: a Model, or a Cage, which is not displaced.";

const std::string makeSubdivisionText = R"(Creates a subdivision surface for a Scene.

model: a Model, or a Cage.
level: )" + levelRange() + R"(, 2**level x 2**level quads per face of 4 vertices.
max_error: as in Grid, in world units. The library's default is 1/36 of the median edge of a face's quads.

A Scene accepts models and cages themselves, too, with the default level.)";

} // namespace

void defineGeometries(py::module_& module) {
  using py::arg;
  const std::pair<float, float> always(0.0f, 1.0f);
  py::class_<Geometry, std::shared_ptr<Geometry>>(module, "Geometry",
                                                  "A geometry of a Scene: Grid, Mesh or Subdivision.")
      .def_property_readonly("num_primitives", &Geometry::numPrimitives,
                             "Number of primitives: faces of a cage or mesh; 1 for a grid.")
      .def_property_readonly("steps", &Geometry::steps, "Number of time steps: 1 if the geometry does not move.")
      .def_readonly("max_error", &Geometry::maxError, "Bound on the spacing of the lattice, or None.")
      .def("__repr__", [](const Geometry& g) {
        return stringOf("<" + g.description() + (g.steps() > 1 ? ", " + countText(g.steps(), "time step") : "") + ">");
      });
  /* Both kinds of grids are of Python's class Grid. */
  py::class_<SurfaceGeometry, Geometry, std::shared_ptr<SurfaceGeometry>>(module, "Grid", gridText)
      .def(py::init([](const py::object& points, const std::optional<float>& maxError, std::pair<float, float> times) {
             return std::shared_ptr<SurfaceGeometry>(makeGrid(points, maxError, times));
           }),
           arg("points"), py::kw_only(), arg("max_error") = py::none(), arg("times") = always, makeGridText)
      .def_static(
          "from_heights",
          [](const py::object& heights, const py::object& cell, const py::object& origin,
             const std::optional<float>& maxError, std::pair<float, float> times) {
            return std::shared_ptr<SurfaceGeometry>(makeHeightGrid(heights, cell, origin, maxError, times));
          },
          arg("heights"), arg("cell") = 1.0, arg("origin") = py::make_tuple(0.0, 0.0, 0.0), py::kw_only(),
          arg("max_error") = py::none(), arg("times") = always, heightsText);
  py::class_<Mesh, Geometry, std::shared_ptr<Mesh>>(module, "Mesh", meshText)
      .def(py::init(&makeMesh), arg("vertices"), arg("indices"), py::kw_only(), arg("max_error") = py::none(),
           arg("times") = always, makeMeshText);
  py::class_<ModelGeometry, Geometry, std::shared_ptr<ModelGeometry>>(module, "Subdivision", subdivisionText)
      .def(py::init(&makeSubdivision), arg("model"), arg("level") = 6, py::kw_only(), arg("max_error") = py::none(),
           makeSubdivisionText.c_str());
}

} // namespace programs::python
