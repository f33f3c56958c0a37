// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A scene of Python. Its kinds are geometries that are built together, a model in one representation, and a file. */

#include "arrays.h"
#include "ray_errors.h"

#include "building/face_numbers.h"
#include "building/traced_scene.h"
#include "tracing/camera.h"

#include <memory>
#include <string>

namespace programs::python {

class Scene {
public:
  virtual ~Scene() = default;

  virtual const TracedScene& traced() const = 0;

  /* Throw Error if the scene stores no triangles that can be read or searched. `operation` is for the message. */
  virtual void requireTriangles(const char* /* operation */) const {}
  virtual void requireSearchable(const char* operation) const { requireTriangles(operation); }

  /* Throws as RayErrors::check. */
  void checkRays() const { errors.check(traced()); }

  /* These two need no Python. Throw Error. */
  virtual Camera camera(const std::string& view, ImageSize size) const = 0;
  virtual void save(const std::string& path) const = 0;

  virtual py::object statistics() const = 0;
  virtual std::string repr() const = 0;

  /* Shared with hits, which may outlive the scene. */
  const std::shared_ptr<const FaceNumbers>& faces() const { return numbers; }

protected:
  explicit Scene(FaceNumbers faces) : numbers(std::make_shared<const FaceNumbers>(std::move(faces))) {}

private:
  std::shared_ptr<const FaceNumbers> numbers;
  RayErrors errors;
};

/* Raises ValueError for negative numbers; 0 is all threads. */
unsigned threadsOf(int threads);

/* Raises ValueError for negative numbers and for numbers that are not finite. */
void requireNotNegative(float value, const char* argument);

/* Raises ValueError if `hits` are of a scene with other faces. */
void requireHitsOf(const Scene& scene, const struct Hits& hits, const char* argument);

/* "3 quads", "1 quad" */
std::string countText(size_t count, const std::string& noun);

} // namespace programs::python
