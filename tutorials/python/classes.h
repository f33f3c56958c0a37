// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pybind11/pybind11.h>

namespace programs::python {

namespace py = pybind11;

void defineCage(py::module_& module);
void defineModel(py::module_& module);       // after Cage
void defineCamera(py::module_& module);      // after Hits
void defineGeometries(py::module_& module);  // after Model
void defineMeshFiles(py::module_& module);   // after the geometries
void defineScene(py::module_& module);       // after Camera, Hits and the geometries
void defineModelScene(py::module_& module);  // after Scene
void defineLoadedScene(py::module_& module); // after Scene
void defineTerrain(py::module_& module);
void defineRasters(py::module_& module); // after Terrain

} // namespace programs::python
