// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Binds common/ to Python for comparing representations in notebooks. */

#include "classes.h"
#include "hits.h"
#include "interruptible.h"

#include "basics/error.h"
#include "basics/setting_name.h"

#include <embree3/rtcore_compression.h>
#include <pybind11/pybind11.h>

#include <exception>

namespace programs::python { namespace {

constexpr const char* moduleText =
    R"(Builds, traces and compares surfaces in the representations of Embree CBVH.

    import embree_cbvh as cbvh

    cage = cbvh.Cage.load("body.obj")
    model = cbvh.Model(cage, "skin.exr", amplitude=0.006)   # or Model.generate("trex")
    scene = cbvh.build(model, "cvert", level=6)
    camera = scene.camera("full", (800, 600))
    hits = scene.intersect(*cbvh.primary_rays(camera))      # hits.t, hits.Ng, ... of shape (600, 800)
    scene.statistics()["bytes_per_quad"]

    scene = cbvh.Scene([cbvh.Grid(points), cbvh.Mesh(vertices, indices), model])   # hits.geomID is the index
    terrain = cbvh.terrain(heights, cell=2, origin=(x, y))  # a raster of any size, in coordinates of 64 bits

Long calls let other Python threads run and can be stopped with Ctrl-C.)";

PyObject* errorType = nullptr; // owned by the module

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const Canceled&) {
    /* ends a thread without a message */
    PyErr_SetNone(interpreterEnds() ? PyExc_SystemExit : PyExc_KeyboardInterrupt);
  } catch (const Error& e) { PyErr_SetObject(errorType, stringOf(e.what()).ptr()); }
}

}} // namespace programs::python

PYBIND11_MODULE(embree_cbvh, module) {
  using namespace programs::python;
  programs::setSettingNames(programs::SettingNames::Arguments);
  module.doc() = moduleText;
  module.attr("__version__") = RTC_COMPRESSION_VERSION_STRING;
  errorType = PyErr_NewExceptionWithDoc("embree_cbvh.Error",
                                        "Raised for invalid files, cages and settings, and for errors of Embree.",
                                        PyExc_ValueError, nullptr);
  if (!errorType) throw py::error_already_set();
  module.attr("Error") = py::handle(errorType);
  py::register_exception_translator(translate);
  py::module_::import("atexit").attr("register")(py::cpp_function(cancelAllAtExit));
  defineHits(module);
  defineCage(module);
  defineModel(module);
  defineCamera(module);
  defineGeometries(module);
  defineMeshFiles(module);
  defineScene(module);
  defineModelScene(module);
  defineLoadedScene(module);
  defineTerrain(module);
  defineRasters(module);
}
